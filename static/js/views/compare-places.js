// @ts-check
/** The list of places behind a number; each opens the review screen there. */

import {formatRoute} from '../model/route.js';
import {trackName} from '../model/track_name.js';
import {fill, h} from './dom.js';
import {count, plural} from './format.js';
import {icon} from './icons.js';
import {showOver} from './second-run.js';

/** @typedef {import('../api/compare-types.js').Comparison} Comparison */
/** @typedef {import('../api/compare-types.js').Places} Places */

/**
 * Where a place opens: the run whose track it is on; for ground truth the other side's run.
 *
 * @param {Comparison} found
 * @param {'reference'|'candidate'} side
 * @returns {{run: string|null, own: boolean}}   own: the track's key is one of that run
 */
export function runOfSide(found, side) {
  const [kind, id] = found[side].split(':');
  if (kind !== 'truth') return {run: id, own: true};
  const [other, otherId] = found[side === 'reference' ? 'candidate' : 'reference'].split(':');
  return {run: other === 'truth' ? null : otherId, own: false};
}

/** @param {string} truth @param {string|null} track */
function sides(truth, track) {
  return track === null ? `truth ${truth}` : `truth ${truth}, ${trackName(track)}`;
}

/**
 * @param {import('../page-types.js').App} app
 * @param {Comparison} found
 * @returns {{element: HTMLElement, show: (places: Places) => void}}
 */
export function createPlaces(app, found) {
  const element = h('aside', {class: 'compare-places', 'aria-label': 'Places behind a number', tabIndex: -1});
  fill(element, h('div', {class: 'empty'}, icon('select'), h('h2', null, 'Places'), h('p', null, 'Choose a number: the frames behind it are listed here, and each opens in the review.')));

  /** @param {Places} places */
  function show({title, side, frames, lasts, tracks, partners, places}) {
    const {run, own} = runOfSide(found, side);
    const second = [found.reference, found.candidate].map((name) => name.split(':')).find(([kind, id]) => kind === 'run' && id !== run)?.[1] ?? null;
    const open = () => showOver(app, run, second);
    fill(element,
      h('div', {class: 'compare-places-head'}, h('h2', {tabIndex: -1}, title), h('span', {class: 'muted small'}, frames.length < places ? `the first ${count(frames.length)} of ${count(places)}` : plural(places, 'place'))),
      h('ol', {class: 'places-list'}, ...frames.map((frame, at) => h('li', null, h('a', {
        class: 'place', onclick: open,
        href: formatRoute({screen: 'review', video: found.video_id, run, frame, track: own ? tracks[at] : partners[at]}),
      }, h('span', {class: 'place-frames'}, lasts[at] > frame ? `frames ${count(frame)}–${count(lasts[at])}` : `frame ${count(frame)}`), h('span', {class: 'grow'}), h('span', {class: 'muted'}, own ? trackName(tracks[at]) : sides(tracks[at], partners[at])), icon('forward'))))));
    element.querySelector('h2')?.focus();
  }

  return {element, show};
}
