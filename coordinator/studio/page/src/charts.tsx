// Charts as SVG: scales and ticks by d3-scale, lines by d3-shape. Every chart has a name and a description, and the
// table of its numbers can be opened under it; marks differ in shape or dash, not in colour alone.
import { scaleLinear } from "d3-scale";
import { area, line } from "d3-shape";
import type { ComponentChildren } from "preact";
import { number } from "./format";

const kWidth = 560;
const kHeight = 260;
const kLeft = 58;
const kRight = 14;
const kTop = 12;
const kBottom = 40;

export interface Series {
  name: string;
  x: number[];
  y: number[];
  style: "a" | "b" | "c" | "d" | "faint"; // colour and dash, style.css
  inLegend?: boolean; // default: yes
}

export interface Band {
  x: number[];
  low: number[];
  high: number[];
  style: "a" | "b" | "c" | "d";
}

export const extent = (values: number[]): [number, number] => {
  let low = Infinity;
  let high = -Infinity;
  for (const value of values) {
    if (Number.isFinite(value)) {
      low = Math.min(low, value);
      high = Math.max(high, value);
    }
  }
  if (!Number.isFinite(low)) {
    return [0, 1];
  }
  const pad = low === high ? Math.abs(low) * 0.05 || 0.5 : (high - low) * 0.05;
  return [low - pad, high + pad];
};

interface FrameProps {
  title: string;
  description: string;
  xName: string;
  yName: string;
  x: [number, number];
  y: [number, number];
  children: (x: (v: number) => number, y: (v: number) => number) => ComponentChildren;
  legend?: ComponentChildren;
  table?: ComponentChildren;
}

export function Frame(props: FrameProps) {
  const x = scaleLinear(props.x, [kLeft, kWidth - kRight]);
  const y = scaleLinear(props.y, [kHeight - kBottom, kTop]);
  return (
    <figure class="chart">
      <figcaption>
        {props.title}
        {props.legend}
      </figcaption>
      <svg viewBox={`0 0 ${kWidth} ${kHeight}`} role="group" aria-label={`${props.title}. ${props.description}`}>
        <g class="axis" aria-hidden="true">
          {y.ticks(5).map((tick) => (
            <g key={tick}>
              <line x1={kLeft} x2={kWidth - kRight} y1={y(tick)} y2={y(tick)} />
              <text x={kLeft - 6} y={y(tick) + 4} text-anchor="end">
                {y.tickFormat(5)(tick)}
              </text>
            </g>
          ))}
          {x.ticks(6).map((tick) => (
            <text key={tick} x={x(tick)} y={kHeight - kBottom + 17} text-anchor="middle">
              {x.tickFormat(6)(tick)}
            </text>
          ))}
          <text x={(kLeft + kWidth - kRight) / 2} y={kHeight - 6} text-anchor="middle">
            {props.xName}
          </text>
          <text class="turned" transform={`translate(13 ${(kTop + kHeight - kBottom) / 2}) rotate(-90)`} text-anchor="middle">
            {props.yName}
          </text>
        </g>
        {props.children(x, y)}
      </svg>
      {props.table}
    </figure>
  );
}

export function Numbers(props: { summary: string; of: string; heads: string[]; rows: (string | number)[][] }) {
  return (
    <details class="numbers">
      <summary>{props.summary}</summary>
      <div class="scroll" tabIndex={0} role="region" aria-label={`${props.of}: ${props.summary}`}>
        <table>
          <thead>
            <tr>
              {props.heads.map((head) => (
                <th key={head} scope="col">
                  {head}
                </th>
              ))}
            </tr>
          </thead>
          <tbody>
            {props.rows.map((row, i) => (
              <tr key={i}>
                {row.map((cell, j) => (
                  <td key={j}>{typeof cell === "number" ? number(cell) : cell}</td>
                ))}
              </tr>
            ))}
          </tbody>
        </table>
      </div>
    </details>
  );
}

const kMostRows = 60; // of a table under a chart; every so many'th of more

export function Lines(props: { title: string; xName: string; yName: string; series: Series[]; bands?: Band[]; zero?: boolean }) {
  const { series } = props;
  const bands = props.bands ?? [];
  const x = extent(series.flatMap((s) => s.x));
  const y = extent([...series.flatMap((s) => s.y), ...bands.flatMap((b) => [...b.low, ...b.high]), ...(props.zero ? [0] : [])]);
  const named = series.filter((s) => s.inLegend !== false);
  const first = series[0];
  const every = Math.ceil((first?.x.length ?? 0) / kMostRows);
  const rows = (first?.x ?? [])
    .map((value, i) => [value, ...series.map((s) => s.y[i] ?? NaN)])
    .filter((_, i, all) => i % every === 0 || i === all.length - 1);
  return (
    <Frame
      title={props.title}
      description={`${props.yName} over ${props.xName}: ${named.map((s) => `${s.name} ends at ${number(s.y[s.y.length - 1] ?? NaN)}`).join(", ")}`}
      xName={props.xName}
      yName={props.yName}
      x={x}
      y={y}
      legend={
        <span class="legend">
          {named.map((s) => (
            <span key={s.name}>
              <svg width="26" height="10" aria-hidden="true">
                <line class={`line ${s.style}`} x1="1" x2="25" y1="5" y2="5" />
              </svg>
              {s.name}
            </span>
          ))}
        </span>
      }
      table={<Numbers summary="the numbers" of={props.title} heads={[props.xName, ...series.map((s) => s.name)]} rows={rows} />}
    >
      {(sx, sy) => (
        <>
          {bands.map((band, i) => (
            <path
              key={`b${i}`}
              class={`band ${band.style}`}
              d={
                area<number>()
                  .x((_, j) => sx(band.x[j] ?? 0))
                  .y0((_, j) => sy(band.low[j] ?? 0))
                  .y1((_, j) => sy(band.high[j] ?? 0))(band.x) ?? ""
              }
            />
          ))}
          {series.map((s) => (
            <path
              key={s.name}
              class={`line ${s.style}`}
              d={
                line<number>()
                  .x((_, j) => sx(s.x[j] ?? 0))
                  .y((_, j) => sy(s.y[j] ?? 0))(s.x) ?? ""
              }
            />
          ))}
        </>
      )}
    </Frame>
  );
}
