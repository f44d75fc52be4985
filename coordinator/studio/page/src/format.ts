// Numbers as people read them.
export const percent = (share: number, digits = 1): string => `${(100 * share).toFixed(digits)} %`;

export function number(value: number): string {
  if (!Number.isFinite(value)) {
    return "–";
  }
  const size = Math.abs(value);
  if (Number.isInteger(value)) {
    return value.toLocaleString("en-GB").replaceAll(",", "\u202f"); // a narrow space: 1 031
  }
  return size >= 100 ? value.toFixed(1) : size >= 1 ? value.toFixed(2) : value.toPrecision(3);
}

export const plusMinus = (mean: number, margin: number, digits = 1): string => `${mean.toFixed(digits)} ± ${margin.toFixed(digits)}`;

export const counted = (count: number, noun: string): string => `${number(count)} ${noun}${count === 1 ? "" : "s"}`;
