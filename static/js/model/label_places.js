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
const GAP = 2;
/** Share of a box or a label that may be covered: boxes of one sign in several layers differ by a pixel or two. */
const BEARABLE = 0.15;
/** Boxes with this overlap belong to one sign, in several layers. */
const ONE_SIGN = 0.3;
/** Cost factor of covering a guarded box. */
const GUARD = 100;
/** Cost factor of covering a label: a covered label cannot be read, but a covered sign is still visible. */
const LABEL_WEIGHT = 5;
/** Maximum distance of a label from its box, lines. */
const FARTHEST = 4;

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
    let least = Number.POSITIVE_INFINITY;
    const near = sides(label, screen);
    [...near, ...further(label, screen)].some(([x, y], i) => {
      const place = /** @type {Box} */ ([x, y, x + wide, y + high]);
      let covered = 0;
      for (const other of wanted) covered += (other.guarded ? GUARD : 1) * shareOf(other.box, place) + strayed(label, place, other);
      for (const other of placed) covered += LABEL_WEIGHT * shareOf(other, place);
      if (covered < least) {
        best = i < near.length ? { x, y } : { x, y, apart: true };
        least = covered;
      }
      return covered <= BEARABLE;
    });
    placed.push([best.x, best.y, best.x + wide, best.y + high]);
    return best;
  });
}

/** @param {WantedLabel} label @param {Size} screen @returns {[number, number][]} best first, all on the screen */
function sides({ box: [x1, y1, x2, y2], wide, high, where }, screen) {
  const kept = within({ wide, high }, screen);
  const above = y1 - high - GAP;
  const below = y2 + GAP;
  const first = where === 'above' ? (above < 0 ? below : above) : below + high > screen.height ? above : below;
  const second = first === above ? below : above;
  return [
    kept(x1 - 1, first),
    kept(x2 + GAP, y1),
    kept(x1 - wide - GAP, y1),
    kept(x1 - 1, second),
    kept(x2 - wide + 1, first),
    kept(x2 - wide + 1, second),
  ];
}

/** Places in the lines above and below, nearest first. @param {WantedLabel} label @param {Size} screen @returns {[number, number][]} */
function further({ box: [x1, y1, x2, y2], wide, high }, screen) {
  const kept = within({ wide, high }, screen);
  const line = high + GAP;
  return Array.from({ length: FARTHEST }, (_, i) => (i + 1) * line).flatMap((away) => [
    kept(x1 - 1, y1 - line - away),
    kept(x1 - 1, y2 + GAP + away),
    kept(x2 + GAP, y1 - away),
    kept(x2 + GAP, y1 + away),
    kept(x1 - wide - GAP, y1 - away),
    kept(x1 - wide - GAP, y1 + away),
  ]);
}

/** Moves a corner so that the whole label is on the screen. @param {{wide: number, high: number}} label @param {Size} screen @returns {(x: number, y: number) => [number, number]} */
function within({ wide, high }, screen) {
  return (x, y) => [
    Math.min(Math.max(0, x), Math.max(0, screen.width - wide)),
    Math.min(Math.max(0, y), Math.max(0, screen.height - high)),
  ];
}

/**
 * The share of a label that is inside the box of another sign, 0..1. A small label covers little of a large box, but
 * there it looks like the label of that box.
 *
 * @param {WantedLabel} label @param {Box} place tentative place of the label @param {WantedLabel} other
 */
function strayed(label, place, other) {
  const share = shareOf(place, other.box);
  return share > 0 && iou(label.box, other.box) < ONE_SIGN ? share : 0;
}

/** How much of a box is covered by another, 0..1. @param {Box} a @param {Box} by */
function shareOf(a, by) {
  const wide = Math.min(a[2], by[2]) - Math.max(a[0], by[0]);
  const high = Math.min(a[3], by[3]) - Math.max(a[1], by[1]);
  return wide <= 0 || high <= 0 ? 0 : (wide * high) / ((a[2] - a[0]) * (a[3] - a[1]));
}
