// A tree as a drawing: the root on the left, branches in the order in which they are asked from top to bottom, every
// node as wide as its words. Laid out by d3-hierarchy (Reingold and Tilford 1981, Buchheim et al. 2002). Heat: how
// often a tick comes to each node, as the width and colour of its edge and as a number, so that colour is never the
// only mark. Works with arrow keys.
import { hierarchy, tree as tidy } from "d3-hierarchy";
import { useMemo, useRef } from "preact/hooks";
import type { TreeView, Vocabulary } from "./data";
import { percent } from "./format";
import { type TreeNode, isComposite, nodeText } from "./tree";
import { nodeWords } from "./words";

const kRow = 34;
const kGap = 44; // between a node and its children
const kCharacter = 7.9; // width of one, at the drawing's font size
const kHeight = 24;
const kMargin = 10;
const kHeatWidth = 96; // of the figures behind an action

interface Place {
  index: number;
  node: TreeNode;
  words: string;
  x: number; // left edge
  y: number; // middle
  width: number;
  parent: number | null;
  hidden: number; // nodes below a collapsed one
}

interface Datum {
  index: number;
  node: TreeNode;
  words: string;
  parent: number | null;
  hidden: number;
  children: Datum[];
}

export function wordsOf(node: TreeNode, vocabulary: Vocabulary): string {
  return node.kind === "sequence" ? "→" : node.kind === "selector" ? "?" : nodeWords(node, vocabulary);
}

export function layout(tree: TreeNode, vocabulary: Vocabulary, collapsed: ReadonlySet<number>): { places: Place[]; width: number; height: number } {
  let next = 0;
  const datum = (node: TreeNode, parent: number | null): Datum => {
    const index = next++;
    const closed = collapsed.has(index) && isComposite(node);
    const made: Datum = { index, node, words: wordsOf(node, vocabulary), parent, hidden: 0, children: [] };
    if (isComposite(node)) {
      if (closed) {
        made.hidden = node.size - 1;
        made.words = `${made.words} … ${node.size - 1}`;
        next += node.size - 1;
      } else {
        made.children = node.children.map((child) => datum(child, index));
      }
    }
    return made;
  };
  const root = tidy<Datum>()
    .nodeSize([kRow, 1])
    .separation(() => 1)(hierarchy(datum(tree, null), (d) => d.children));
  const widthOf = (d: Datum): number => Math.max(30, d.words.length * kCharacter + 18);
  // Every level is as wide as its widest node, so that no two levels overlap.
  const columns: number[] = [];
  root.each((at) => {
    columns[at.depth] = Math.max(columns[at.depth] ?? 0, widthOf(at.data) + (at.data.node.kind === "action" && at.height === 0 ? kHeatWidth - kGap : 0));
  });
  const left = columns.map((_, depth) => columns.slice(0, depth).reduce((sum, width) => sum + width + kGap, kMargin));
  const places: Place[] = [];
  let top = Infinity;
  let bottom = -Infinity;
  let right = 0;
  root.eachBefore((at) => {
    const x = left[at.depth] ?? 0;
    top = Math.min(top, at.x);
    bottom = Math.max(bottom, at.x);
    right = Math.max(right, x + widthOf(at.data));
    places.push({ index: at.data.index, node: at.data.node, words: at.data.words, x, y: at.x, width: widthOf(at.data), parent: at.data.parent, hidden: at.data.hidden });
  });
  for (const place of places) {
    place.y += kRow / 2 + kMargin - top;
  }
  return { places, width: right + kHeatWidth, height: bottom - top + kRow + 2 * kMargin };
}

export interface TreeDrawingProps {
  tree: TreeNode;
  vocabulary: Vocabulary;
  title: string;
  view: TreeView | null;
  selected: number | null;
  onSelect: (node: number | null) => void;
  lit?: ReadonlyMap<number, boolean> | null;
  matches?: ReadonlySet<number>; // of a search
  marks?: ReadonlyMap<number, string>; // node -> class: a rule's roles, a difference
  collapsed?: ReadonlySet<number>;
  onCollapse?: (node: number) => void;
  scale?: number;
  onKey?: (event: KeyboardEvent) => boolean; // true: it was for the editor
  onDropOn?: (from: number, to: number) => void;
}

const kNone: ReadonlySet<number> = new Set();

// The node that an arrow key leads to.
function neighbour(places: Place[], from: number, key: string): number | null {
  const at = places.find((p) => p.index === from);
  if (!at) {
    return 0;
  }
  if (key === "ArrowLeft") {
    return at.parent;
  }
  if (key === "ArrowRight") {
    return places.find((p) => p.parent === from)?.index ?? null;
  }
  const rows = [...places].sort((a, b) => a.y - b.y || a.x - b.x);
  const siblings = rows.filter((p) => p.parent === at.parent);
  const step = key === "ArrowDown" ? 1 : -1;
  const sibling = siblings[siblings.findIndex((p) => p.index === from) + step];
  if (sibling) {
    return sibling.index;
  }
  const beyond = rows.filter((p) => (step > 0 ? p.y > at.y : p.y < at.y)).sort((a, b) => Math.abs(a.y - at.y) - Math.abs(b.y - at.y));
  return beyond[0]?.index ?? null;
}

export function TreeDrawing(props: TreeDrawingProps) {
  const { tree, vocabulary, view, selected } = props;
  const collapsed = props.collapsed ?? kNone;
  const { places, width, height } = useMemo(() => layout(tree, vocabulary, collapsed), [tree, vocabulary, collapsed]);
  const svg = useRef<SVGSVGElement>(null);
  const byIndex = new Map(places.map((place) => [place.index, place]));
  const scale = props.scale ?? 1;
  const share = (figures: number[] | undefined, index: number): number => (view && view.steps > 0 ? (figures?.[index] ?? 0) / view.steps : 0);

  const focus = (index: number): void => {
    props.onSelect(index);
    requestAnimationFrame(() => svg.current?.querySelector<SVGGElement>(`[data-node="${index}"]`)?.focus());
  };
  const onKeyDown = (event: KeyboardEvent): void => {
    if (props.onKey?.(event)) {
      event.preventDefault();
      return;
    }
    if (event.ctrlKey || event.metaKey || event.altKey) {
      return;
    }
    if (event.key.startsWith("Arrow")) {
      const next = neighbour(places, selected ?? 0, event.key);
      if (next !== null) {
        focus(next);
      }
      event.preventDefault();
    } else if (event.key === "Home") {
      focus(0);
      event.preventDefault();
    } else if (event.key === "Escape") {
      props.onSelect(null);
    } else if ((event.key === "Enter" || event.key === " ") && selected !== null && props.onCollapse) {
      props.onCollapse(selected);
      event.preventDefault();
    }
  };

  return (
    <svg
      ref={svg}
      class="tree"
      role="tree"
      aria-label={props.title}
      viewBox={`0 0 ${width} ${height}`}
      width={width * scale}
      height={height * scale}
      onKeyDown={onKeyDown}
    >
      {places.map((place) => {
        const parent = place.parent === null ? null : byIndex.get(place.parent);
        if (!parent) {
          return null;
        }
        const heat = share(view?.ticked, place.index);
        const x0 = parent.x + parent.width;
        const middle = (x0 + place.x) / 2;
        const on = props.lit ? props.lit.has(place.index) : false;
        return (
          <path
            key={`e${place.index}`}
            class={`edge${on ? " lit" : ""}${view && heat === 0 ? " cold" : ""}`}
            d={`M${x0},${parent.y}C${middle},${parent.y} ${middle},${place.y} ${place.x},${place.y}`}
            stroke-width={1 + 7 * Math.sqrt(heat)}
          />
        );
      })}
      {places.map((place) => {
        const { node, index } = place;
        const decides = share(view?.decides, index);
        const heat = share(view?.ticked, index);
        const on = props.lit?.get(index);
        const classes = [
          "node",
          node.kind,
          selected === index ? "selected" : "",
          on === undefined ? "" : on ? "lit succeeded" : "lit failed",
          props.matches?.has(index) ? "found" : "",
          props.marks?.get(index) ?? "",
          view && heat === 0 ? "cold" : "",
        ].join(" ");
        const text = nodeText(node, vocabulary);
        const name = isComposite(node) || place.words === text ? text : `${place.words} (${text})`;
        const decided = node.kind === "action" ? `, decides ${percent(decides)}` : "";
        const label = view ? `${name}, ticked in ${percent(heat)} of the steps${decided}` : name;
        return (
          <g
            key={`n${index}`}
            class={classes}
            data-node={index}
            role="treeitem"
            aria-label={label}
            aria-selected={selected === index}
            aria-level={levelOf(places, place)}
            tabindex={selected === index || (selected === null && index === 0) ? 0 : -1}
            onClick={(event) => {
              event.stopPropagation();
              focus(index);
            }}
            onDblClick={() => props.onCollapse?.(index)}
            {...dragging(props, index)}
          >
            <title>{label}</title>
            {node.kind === "condition" ? (
              <rect x={place.x} y={place.y - kHeight / 2} width={place.width} height={kHeight} rx={kHeight / 2} />
            ) : (
              <rect x={place.x} y={place.y - kHeight / 2} width={place.width} height={kHeight} rx={isComposite(node) ? 5 : 0} />
            )}
            <text x={place.x + place.width / 2} y={place.y + 4.5} text-anchor="middle">
              {place.words}
            </text>
          </g>
        );
      })}
      {view && (
        <g aria-hidden="true">
          {places
            .filter((place) => place.node.kind === "action")
            .map((place) => {
              const decides = share(view.decides, place.index);
              const differs = share(view.differs, place.index);
              return (
                <text class="heat" key={place.index} x={place.x + place.width + 5} y={place.y + 4}>
                  {percent(decides, decides > 0 && decides < 0.01 ? 2 : 0)}
                  {differs > 0.0005 ? ` ≠${percent(differs, differs < 0.01 ? 1 : 0)}` : ""}
                </text>
              );
            })}
        </g>
      )}
    </svg>
  );
}

function levelOf(places: Place[], place: Place): number {
  let level = 1;
  let at: Place | undefined = place;
  while (at && at.parent !== null) {
    const parent: number = at.parent;
    at = places.find((p) => p.index === parent);
    ++level;
  }
  return level;
}

// Moving a node by pointer: pressed on one, released on another.
function dragging(props: TreeDrawingProps, index: number) {
  if (!props.onDropOn) {
    return {};
  }
  return {
    onPointerDown: (event: PointerEvent) => {
      if (event.button === 0) {
        dragged = index;
        (event.currentTarget as Element).releasePointerCapture?.(event.pointerId);
      }
    },
    onPointerUp: () => {
      if (dragged !== null && dragged !== index) {
        props.onDropOn?.(dragged, index);
      }
      dragged = null;
    },
  };
}
let dragged: number | null = null;
