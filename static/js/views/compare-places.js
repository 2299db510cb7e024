// @ts-check
/** The list of places behind a number; each opens the review screen there. */

import {formatRoute} from '../model/route.js';
import {trackName} from '../model/track_name.js';
import {fill, h} from './dom.js';
import {count, plural} from './format.js';
import {icon} from './icons.js';
import {openOver} from './open-over.js';

/** @typedef {import('../api/compare-types.js').Comparison} Comparison */
/** @typedef {import('../api/compare-types.js').Places} Places */

/**
 * What a place opens, so that both sides are seen there: the run whose track it is on; for ground truth the other side's
 * run with the truth over it; where one side is corrections the run that they belong to, for they lie on no other.
 *
 * @param {Comparison} found
 * @param {'reference'|'candidate'} side
 * @returns {{run: string|null, own: boolean, second: {run: string, corrected: boolean}|null, truth: string|null}}
 *   own: the track's key is one of that run; second, truth: what lies over it
 */
export function viewOf(found, side) {
  const [[kind, id], [otherKind, otherId]] = [found[side], found[side === 'reference' ? 'candidate' : 'reference']].map((name) => name.split(':'));
  if (kind === 'truth' && otherKind === 'truth') return {run: null, own: false, second: null, truth: id};
  if (kind === 'truth' || otherKind === 'truth') {
    const own = otherKind === 'truth';
    const run = own ? id : otherId;
    // the review shows the run as people corrected it; what was measured is what the engine had
    const raw = found.sides[own === (side === 'reference') ? 'reference' : 'candidate'];
    return {run, own, second: raw.kind === 'run' && raw.edited ? {run, corrected: false} : null, truth: own ? otherId : id};
  }
  const own = kind === 'annotation' || otherKind === 'run' || id === otherId;
  const [over, overKind] = own ? [otherId, otherKind] : [id, kind];
  return {run: own ? id : otherId, own, second: {run: over, corrected: overKind === 'annotation' && id !== otherId}, truth: null};
}

/**
 * Which track a place is on: the one that opens by its name, the other side's with what lies on it here.
 *
 * @param {Comparison} found
 * @param {Places} places
 * @param {{own: boolean, truth: string|null}} view   what the place opens
 * @param {number} at
 */
export function sides(found, {side, tracks, partners}, {own, truth}, at) {
  const other = side === 'reference' ? 'candidate' : 'reference';
  /** @param {'reference'|'candidate'} whose @param {string} key */
  const nameOf = (whose, key) => found.sides[whose].names[key] ?? trackName(key);
  if (own) return nameOf(side, tracks[at]);
  const name = truth === null ? `${nameOf(side, tracks[at])} of the other run` : `truth ${tracks[at]}`;
  const partner = partners[at];
  return partner === null ? name : `${name}, ${nameOf(other, partner)}`;
}

/**
 * @param {import('../page-types.js').App} app
 * @param {Comparison} found
 * @returns {{element: HTMLElement, show: (places: Places) => void}}
 */
export function createPlaces(app, found) {
  const element = h('aside', {class: 'compare-places', 'aria-label': 'Places behind a number', tabIndex: -1});
  fill(element, h('div', {class: 'empty'}, icon('select'), h('h2', null, 'Places'), h('p', null, 'Choose a number: the frames behind it are listed here, and each opens in the review.')));

  /** @param {Places} shown */
  function show(shown) {
    const {title, side, frames, lasts, tracks, partners, places, errors} = shown;
    const view = viewOf(found, side);
    const {run, own} = view;
    const open = () => openOver(app, run, view);
    fill(element,
      h('div', {class: 'compare-places-head'}, h('h2', {tabIndex: -1}, title), h('span', {class: 'muted small'}, frames.length < places ? `the first ${count(frames.length)} of ${count(places)}` : plural(places, 'place'))),
      h('ol', {class: 'places-list'}, ...frames.map((frame, at) => h('li', null, h('a', {
        class: 'place', onclick: open,
        href: formatRoute({screen: 'review', video: found.video_id, run, frame, track: own ? tracks[at] : partners[at]}),
      }, h('span', {class: 'place-frames'}, lasts[at] > frame ? `frames ${count(frame)}–${count(lasts[at])}` : `frame ${count(frame)}`), errors && h('span', {class: 'place-error', title: 'Error of this box'}, errors[at].toFixed(3)), h('span', {class: 'grow'}), h('span', {class: 'muted'}, sides(found, shown, view, at)), icon('forward'))))));
    element.querySelector('h2')?.focus();
  }

  return {element, show};
}
