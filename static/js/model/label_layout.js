// @ts-check
/**
 * Places the labels of boxes so that none hides a sign: several signs often hang on one post, and a label above the
 * middle one would cover the sign over it. Pure; in CSS px of the screen.
 *
 * @typedef {import('../types.js').Box} Box
 * @typedef {import('./geometry.js').Size} Size
 *
 * @typedef {object} WantedLabel
 * @property {Box} box
 * @property {number} wide
 * @property {number} high
 * @property {'above'|'below'} where    preferred place
 * @property {boolean} [guarded]          labels avoid this box as long as there is another place
 */

import { iou } from './geometry.js';

/** Distance between a box and its label. */
const GAP_PX = 2;
/** Share of a box or a label that may be covered: boxes of one sign in several layers differ by a pixel or two. */
const MAX_COVERED_SHARE = 0.15;
/** Boxes with this overlap belong to one sign, in several layers. */
const SAME_SIGN_IOU = 0.3;
/** Cost factor of covering a guarded box. */
const GUARDED_WEIGHT = 100;
/** Cost factor of covering a label: a covered label cannot be read, but a covered sign is still visible. */
const LABEL_WEIGHT = 5;
/** Maximum distance of a label from its box, lines. */
const MAX_DISTANCE_LINES = 4;

/**
 * Places for labels, in their order: the preferred place, else another side of the box, else some lines away from it,
 * else the place that covers the least of the boxes (including its own) and of earlier labels.
 *
 * @param {readonly WantedLabel[]} wanted   most important first
 * @param {Size} screen
 * @returns {({x: number, y: number, apart?: true}|null)[]} upper left corners; `apart`: not beside its box; null: the box is not on the screen
 */
export function placeLabels(wanted, screen) {
  /** @type {Box[]} */
  const placed = [];
  return wanted.map((label) => {
    const { box, wide, high } = label;
    if (box[2] <= 0 || box[3] <= 0 || box[0] >= screen.width || box[1] >= screen.height) return null;
    /** @type {{x: number, y: number, apart?: true}} */
    let best = { x: 0, y: 0 };
    let minCovered = Number.POSITIVE_INFINITY;
    const near = adjacentPositions(label, screen);
    [...near, ...fartherPositions(label, screen)].some(([x, y], i) => {
      const candidate = /** @type {Box} */ ([x, y, x + wide, y + high]);
      let covered = 0;
      for (const other of wanted)
        covered += (other.guarded ? GUARDED_WEIGHT : 1) * shareOf(other.box, candidate) + shareInsideOther(label, candidate, other);
      for (const other of placed) covered += LABEL_WEIGHT * shareOf(other, candidate);
      if (covered < minCovered) {
        best = i < near.length ? { x, y } : { x, y, apart: true };
        minCovered = covered;
      }
      return covered <= MAX_COVERED_SHARE;
    });
    placed.push([best.x, best.y, best.x + wide, best.y + high]);
    return best;
  });
}

/** @param {WantedLabel} label @param {Size} screen @returns {[number, number][]} best first, all on the screen */
function adjacentPositions({ box: [x1, y1, x2, y2], wide, high, where }, screen) {
  const clamped = clampToScreen({ wide, high }, screen);
  const above = y1 - high - GAP_PX;
  const below = y2 + GAP_PX;
  const first = where === 'above' ? (above < 0 ? below : above) : below + high > screen.height ? above : below;
  const second = first === above ? below : above;
  return [
    clamped(x1 - 1, first),
    clamped(x2 + GAP_PX, y1),
    clamped(x1 - wide - GAP_PX, y1),
    clamped(x1 - 1, second),
    clamped(x2 - wide + 1, first),
    clamped(x2 - wide + 1, second),
  ];
}

/** Places in the lines above and below, nearest first. @param {WantedLabel} label @param {Size} screen @returns {[number, number][]} */
function fartherPositions({ box: [x1, y1, x2, y2], wide, high }, screen) {
  const clamped = clampToScreen({ wide, high }, screen);
  const line = high + GAP_PX;
  return Array.from({ length: MAX_DISTANCE_LINES }, (_, i) => (i + 1) * line).flatMap((distance) => [
    clamped(x1 - 1, y1 - line - distance),
    clamped(x1 - 1, y2 + GAP_PX + distance),
    clamped(x2 + GAP_PX, y1 - distance),
    clamped(x2 + GAP_PX, y1 + distance),
    clamped(x1 - wide - GAP_PX, y1 - distance),
    clamped(x1 - wide - GAP_PX, y1 + distance),
  ]);
}

/** Moves a corner so that the whole label is on the screen. @param {{wide: number, high: number}} label @param {Size} screen @returns {(x: number, y: number) => [number, number]} */
function clampToScreen({ wide, high }, screen) {
  return (x, y) => [
    Math.min(Math.max(0, x), Math.max(0, screen.width - wide)),
    Math.min(Math.max(0, y), Math.max(0, screen.height - high)),
  ];
}

/**
 * The share of a label inside the box of another sign, 0..1. A small label covers little of a large box, but
 * there it looks like the label of that box.
 *
 * @param {WantedLabel} label @param {Box} candidate tentative place of the label @param {WantedLabel} other
 */
function shareInsideOther(label, candidate, other) {
  const share = shareOf(candidate, other.box);
  return share > 0 && iou(label.box, other.box) < SAME_SIGN_IOU ? share : 0;
}

/** How much of a box is covered by another, 0..1. @param {Box} a @param {Box} by */
function shareOf(a, by) {
  const wide = Math.min(a[2], by[2]) - Math.max(a[0], by[0]);
  const high = Math.min(a[3], by[3]) - Math.max(a[1], by[1]);
  return wide <= 0 || high <= 0 ? 0 : (wide * high) / ((a[2] - a[0]) * (a[3] - a[1]));
}
