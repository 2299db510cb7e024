// @ts-check
/** Numbers, sizes, times and shares as text: thousands with commas, never with an exponent. Pure. */

import { timeLabel } from './time_axis.js';

/** Smaller numbers are shown as `<0.0001`. */
const SMALL = 1e-4;

/** @param {number|null|undefined} value @returns {string} `132,400` */
export function count(value) {
  return value === null || value === undefined ? '–' : value.toLocaleString('en-GB');
}

/** @param {number} value @param {string} one @param {string} [many] @returns {string} `1 run`, `3 runs` */
export function plural(value, one, many = `${one}s`) {
  return `${count(value)} ${value === 1 ? one : many}`;
}

/**
 * @param {number|null|undefined} value
 * @param {number} [digits]   significant digits; with up to three, very small numbers are shown as `<0.0001`
 * @returns {string} `4.19`, `1,230`, `<0.0001`
 */
export function figure(value, digits = 3) {
  if (value === null || value === undefined || !Number.isFinite(value)) return '–';
  if (Number.isInteger(value)) return count(value + 0); // + 0: never -0
  if (digits <= 3 && Math.abs(value) < SMALL) return value > 0 ? `<${SMALL.toFixed(4)}` : `>-${SMALL.toFixed(4)}`;
  return value.toLocaleString('en-GB', { maximumSignificantDigits: digits });
}

/** @param {number|null|undefined} bytes @returns {string} `3.7 MB` */
export function bytes(bytes) {
  if (bytes === null || bytes === undefined) return '–';
  const units = ['bytes', 'kB', 'MB', 'GB', 'TB'];
  let value = bytes;
  let unit = 0;
  while (value >= 999.5 && unit < units.length - 1) {
    value /= 1000;
    unit += 1;
  }
  return `${unit === 0 || value >= 99.5 ? Math.round(value) : value.toFixed(1)} ${units[unit]}`;
}

/** @param {number|null|undefined} seconds @returns {string} `0:12`, `1:02:03` */
export function clock(seconds) {
  return seconds === null || seconds === undefined || !Number.isFinite(seconds) ? '–' : timeLabel(seconds, 1);
}

/** @param {string} text */
export const capitalized = (text) => text.charAt(0).toUpperCase() + text.slice(1);

/** @param {number|null|undefined} seconds @returns {string} time left in words: `about 2 min left` */
export function timeLeft(seconds) {
  if (seconds === null || seconds === undefined || !Number.isFinite(seconds)) return '';
  if (seconds < 5) return 'a few seconds left';
  if (seconds < 55) return `about ${Math.ceil(seconds / 5) * 5} s left`;
  if (seconds < 55 * 60) return `about ${Math.round(seconds / 60)} min left`;
  return `about ${(seconds / 3600).toFixed(1)} h left`;
}

/** @param {number} first @param {number} last   both included @returns {string} `20`, `20–34` */
export const frameSpan = (first, last) => (first === last ? count(first) : `${count(first)}–${count(last)}`);

/** @param {number|null|undefined} share 0..1 @returns {string} `93.1 %` */
export function percent(share) {
  return share === null || share === undefined ? '–' : `${(share * 100).toFixed(share === 1 || share === 0 ? 0 : 1)} %`;
}

/** @param {number|null|undefined} share 0..1 @returns {string} `93 %`; `<1 %` and `>99 %` if it is not exactly 0 or 1 */
export function roundPercent(share) {
  if (share === null || share === undefined) return '–';
  if (share > 0 && share < 0.01) return '<1 %';
  if (share > 0.99 && share < 1) return '>99 %';
  return `${Math.round(share * 100)} %`;
}

/** @param {string|null|undefined} iso @returns {string} `21 Nov 2026, 06:20` in the reader's time zone */
export function moment(iso) {
  if (!iso) return '–';
  // The server's times are UTC, with or without a zone.
  const time = new Date(/(Z|[+-]\d\d:\d\d)$/.test(iso) ? iso : `${iso}Z`);
  if (Number.isNaN(time.getTime())) return '–';
  return time.toLocaleString('en-GB', { day: 'numeric', month: 'short', year: 'numeric', hour: '2-digit', minute: '2-digit' });
}
