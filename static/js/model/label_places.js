// @ts-check
/**
 * Where the labels of boxes stand, so that none hides a sign: several signs often hang on one post, and a label above the
 * middle one would lie on the one over it. Pure; on the screen, in CSS px.
 *
 * @typedef {import('../types.js').Box} Box
 * @typedef {import('./geometry.js').Size} Size
 *
 * @typedef {object} WantedLabel
 * @property {Box} box
 * @property {number} wide
 * @property {number} high
 * @property {'above'|'below'} where    where it stands if nothing speaks against it
 * @property {boolean} [guarded]          no label may lie on the box while there is another place
 */

import { iou } from './geometry.js';

/** Between a box and its label. */
const GAP = 2;
/** This share of a box or a label may be covered: the boxes that several layers have of one sign differ by a pixel or two. */
const BEARABLE = 0.15;
/** Boxes that share so much of their area are of one sign: what several layers say of it. */
const ONE_SIGN = 0.3;
/** Nothing that is covered of a guarded box is bearable. */
const GUARD = 100;
/** A covered label cannot be read, a covered sign can still be seen. */
const LABEL_WEIGHT = 5;
/** How many lines away from its box a label may stand. */
const FARTHEST = 4;

/**
 * A place for each label, in their order: where it was wanted, else on another side of its box, else some lines away from
 * it, else where it covers least of the boxes, its own too, and of the labels before it.
 *
 * @param {readonly WantedLabel[]} wanted   the most important first
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

/** @param {WantedLabel} label @param {Size} screen @returns {[number, number][]} the best first, all on the screen */
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

/** Places in the lines above and below, the nearest first. @param {WantedLabel} label @param {Size} screen @returns {[number, number][]} */
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

/** Moves a corner so that all of its label is on the screen. @param {{wide: number, high: number}} label @param {Size} screen @returns {(x: number, y: number) => [number, number]} */
function within({ wide, high }, screen) {
  return (x, y) => [
    Math.min(Math.max(0, x), Math.max(0, screen.width - wide)),
    Math.min(Math.max(0, y), Math.max(0, screen.height - high)),
  ];
}

/**
 * How much of a label lies in the box of another sign, 0..1: from near a small label covers little of a large box, but reads
 * as if it were that one's.
 *
 * @param {WantedLabel} label @param {Box} place where it would stand @param {WantedLabel} other
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
