// @ts-check
/**
 * The list of places behind a number, with both sides. Each place opens the review screen, and ground truth can be
 * taken over.
 */

import { cropRegion, cssPosition } from '../model/crop_region.js';
import { labelName } from '../model/labels.js';
import { formatRoute } from '../model/route.js';
import { trackName } from '../model/track_name.js';
import { fill, h } from './dom.js';
import { count, plural } from '../model/format.js';
import { icon } from './icons.js';
import { openOver } from './open-over.js';
import { pictureThatMayMiss } from './pictures.js';
import { takeOver } from '../review/take_over.js';

/** @typedef {import('../api/compare-types.js').Comparison} Comparison */
/** @typedef {import('../api/compare-types.js').Places} Places */

/**
 * The view that a place opens, so that both sides are visible: the run of the place's track; for ground truth the other
 * side's run with the ground truth on top; for corrections the run that they belong to, because they fit no other.
 *
 * @param {Comparison} found
 * @param {'reference'|'candidate'} side
 * @returns {{run: string|null, own: boolean, second: {run: string, corrected: boolean}|null, truth: string|null}}
 *   own: the track's key belongs to that run; second, truth: layers on top of it
 */
export function viewOf(found, side) {
  const [[kind, id], [otherKind, otherId]] = [found[side], found[side === 'reference' ? 'candidate' : 'reference']].map((name) =>
    name.split(':'),
  );
  if (kind === 'truth' && otherKind === 'truth') return { run: null, own: false, second: null, truth: id };
  if (kind === 'truth' || otherKind === 'truth') {
    const own = otherKind === 'truth';
    const run = own ? id : otherId;
    // the review shows a run with corrections, but the engine's results were measured
    const raw = found.sides[own === (side === 'reference') ? 'reference' : 'candidate'];
    return { run, own, second: raw.kind === 'run' && raw.edited ? { run, corrected: false } : null, truth: own ? otherId : id };
  }
  const own = kind === 'annotation' || otherKind === 'run' || id === otherId;
  const [over, overKind] = own ? [otherId, otherKind] : [id, kind];
  return { run: own ? id : otherId, own, second: { run: over, corrected: overKind === 'annotation' && id !== otherId }, truth: null };
}

/**
 * The tracks at a place: the one that opens by its name, and the other side's track with its overlap here.
 *
 * @param {Comparison} found
 * @param {Places} places
 * @param {{own: boolean, truth: string|null}} view   the view that the place opens
 * @param {number} at
 */
export function sides(found, { side, tracks, partners }, { own, truth }, at) {
  const other = side === 'reference' ? 'candidate' : 'reference';
  /** @param {'reference'|'candidate'} whose @param {string} key */
  const nameOf = (whose, key) => found.sides[whose].names[key] ?? trackName(key);
  if (own) return nameOf(side, tracks[at]);
  const name = truth === null ? `${nameOf(side, tracks[at])} of the other run` : `truth ${tracks[at]}`;
  const partner = partners[at];
  return partner === null ? name : `${name}, ${nameOf(other, partner)}`;
}

/** Side of a crop, CSS px. */
const CROP = 64;

/**
 * The ground truth of a comparison and the run that can be corrected with it; null: no ground truth, or no run to correct.
 *
 * @param {Pick<Comparison, 'reference'|'candidate'>} found
 * @returns {{truth: string, side: 'reference'|'candidate', run: string}|null}
 */
function correctable({ reference, candidate }) {
  const [[kind, id], [otherKind, otherId]] = [reference, candidate].map((name) => name.split(':'));
  if ((kind === 'truth') === (otherKind === 'truth')) return null;
  return kind === 'truth' ? { truth: id, side: 'reference', run: otherId } : { truth: otherId, side: 'candidate', run: id };
}

/**
 * The sign of the ground truth at a place; null: none.
 *
 * @param {Pick<Places, 'side'|'tracks'|'pairs'>} places
 * @param {'reference'|'candidate'} side   side of the ground truth
 * @param {number} at
 * @returns {number|null}
 */
function signAt({ side: own, tracks, pairs }, side, at) {
  const key = own === side ? tracks[at] : pairs[at].other;
  return key === null ? null : Number(key.slice(1));
}

/**
 * @param {import('../page-types.js').App} app
 * @param {Comparison} found
 * @param {readonly import('../types.js').Label[]} labels
 * @param {() => void} changed   called when the corrections of a side have changed
 * @returns {{element: HTMLElement, show: (places: Places) => void}}
 */
export function createPlaces(app, found, labels, changed) {
  const element = h('aside.compare-places', { 'aria-label': 'Places behind a number', tabIndex: -1 });
  fill(
    element,
    h('div.empty', icon('select'), h('h2', 'Places'), h('p', 'Choose a number to list the frames behind it. Each opens in the review.')),
  );

  /** @param {Places} shown */
  function show(shown) {
    const { title, side, frames, lasts, tracks, partners, pairs, places, errors } = shown;
    const view = viewOf(found, side);
    const { run, own } = view;
    const from = correctable(found);
    const signs = from ? [...new Set(frames.map((_, at) => signAt(shown, from.side, at)).filter((sign) => sign !== null))] : [];
    /** @param {number[]} some */
    const take = (some) => from && takeOver(app, from.run, { truth: from.truth, signs: some }, changed);
    /** @param {number} at */
    function row(at) {
      const frame = frames[at];
      const pair = pairs[at];
      const sign = from && signAt(shown, from.side, at);
      const both = pair.other_box === null ? [pair.box] : [pair.box, pair.other_box];
      const region = cropRegion(both, found);
      const open = () => openOver(app, run, view, { frame, box: enclosing(both), sign });
      return h(
        'li.place-row',
        h(
          'a.place',
          {
            onclick: open,
            href: formatRoute({
              screen: 'review',
              video: found.video_id,
              run,
              frame,
              track: own ? tracks[at] : (partners[at] ?? pair.other),
            }),
          },
          crop(frame, region, side, pair),
          h(
            'span.stack.place-text',
            h(
              'span.row',
              h('span.place-frames', lasts[at] > frame ? `frames ${count(frame)}–${count(lasts[at])}` : `frame ${count(frame)}`),
              errors && h('span.place-error', { title: 'Error of this box' }, errors[at].toFixed(3)),
            ),
            h('span.small', pairWords(found, side, pair, labels)),
            h('span.muted.small.truncate', sides(found, shown, view, at)),
          ),
          icon('forward'),
        ),
        sign !== null &&
          h(
            'button.btn.btn-small',
            {
              title: `Take over sign ${sign} of the ground truth: all its boxes and its label`,
              'aria-label': `Take over sign ${sign} at frame ${count(frame)}`,
              onclick: () => take([sign]),
            },
            'Take over',
          ),
      );
    }
    fill(
      element,
      h(
        'div.compare-places-head.row',
        h(
          'div.stack.grow',
          h('h2', { tabIndex: -1 }, title),
          h('span.muted.small', frames.length < places ? `the first ${count(frames.length)} of ${count(places)}` : plural(places, 'place')),
        ),
        signs.length > 1 &&
          h(
            'button.btn.btn-small',
            { title: 'Take over the signs of all these places, in one step that can be undone', onclick: () => take(signs) },
            `Take over ${plural(signs.length, 'sign')}`,
          ),
      ),
      h('ol.places-list', ...frames.map((_, at) => row(at))),
    );
    element.querySelector('h2')?.focus();
  }

  /**
   * The picture around a place, with both boxes; loaded when it becomes visible.
   * @param {number} frame
   * @param {import('../types.js').Box} region
   * @param {'reference'|'candidate'} side   of the pair's own box
   * @param {import('../api/compare-types.js').Pair} pair
   */
  function crop(frame, region, side, { box, other_box: other }) {
    /** @param {import('../types.js').Box} one @param {'reference'|'candidate'} whose */
    const frameOf = (one, whose) => h('span', { class: `place-box place-box-${whose}`, style: cssPosition(one, region) });
    return h(
      'span.place-crop',
      pictureThatMayMiss({
        src: app.api.framePartUrl(found.video_id, frame, region, CROP * 2),
        width: CROP,
        height: CROP,
        loading: 'lazy',
      }),
      frameOf(box, side),
      other && frameOf(other, side === 'reference' ? 'candidate' : 'reference'),
    );
  }

  return { element, show };
}

/** @param {readonly import('../types.js').Box[]} boxes @returns {import('../types.js').Box} */
const enclosing = (boxes) => [
  Math.min(...boxes.map((box) => box[0])),
  Math.min(...boxes.map((box) => box[1])),
  Math.max(...boxes.map((box) => box[2])),
  Math.max(...boxes.map((box) => box[3])),
];

/**
 * The labels of both sides, the reference first, and the overlap of their boxes.
 *
 * @param {Pick<Comparison, 'confusion'>} found
 * @param {'reference'|'candidate'} side   of the pair's own box
 * @param {import('../api/compare-types.js').Pair} pair
 * @param {readonly import('../types.js').Label[]} labels
 */
export function pairWords({ confusion }, side, { label, other, other_label, iou }, labels) {
  /** @param {number|null} id */
  const name = (id) => confusion.words?.[String(id)] ?? labelName(labels, id);
  if (other === null) return `${name(label)}, no box of the ${side === 'reference' ? 'candidate' : 'reference'} on it`;
  const [a, b] = side === 'reference' ? [label, other_label] : [other_label, label];
  return `${a === b ? name(a) : `${name(a)} → ${name(b)}`}, IoU ${iou.toFixed(2)}`;
}
