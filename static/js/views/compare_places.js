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
import { showInReview } from './show_in_review.js';
import { imageWithPlaceholder } from './images.js';
import { takeOver } from '../review/take_over.js';

/** @typedef {import('../api/compare-types.js').Comparison} Comparison */
/** @typedef {import('../api/compare-types.js').Places} Places */

/**
 * The view that a place opens, so that both sides are visible: the run of the place's track; for ground truth the other
 * side's run with the ground truth on top; for corrections the run that they belong to, because they fit no other.
 *
 * @param {Comparison} comparison
 * @param {'reference'|'candidate'} side
 * @returns {{run: string|null, hasTrack: boolean, second: {run: string, corrected: boolean}|null, truth: string|null}}
 *   hasTrack: the track's key belongs to that run; second, truth: layers on top of it
 */
export function reviewTarget(comparison, side) {
  const [[kind, id], [otherKind, otherId]] = [comparison[side], comparison[side === 'reference' ? 'candidate' : 'reference']].map((name) =>
    name.split(':'),
  );
  if (kind === 'truth' && otherKind === 'truth') return { run: null, hasTrack: false, second: null, truth: id };
  if (kind === 'truth' || otherKind === 'truth') {
    const hasTrack = otherKind === 'truth';
    const run = hasTrack ? id : otherId;
    // the review shows a run with corrections, but the engine's results were measured
    const measuredSide = comparison.sides[hasTrack === (side === 'reference') ? 'reference' : 'candidate'];
    return {
      run,
      hasTrack,
      second: measuredSide.kind === 'run' && measuredSide.edited ? { run, corrected: false } : null,
      truth: hasTrack ? otherId : id,
    };
  }
  const hasTrack = kind === 'annotation' || otherKind === 'run' || id === otherId;
  const [secondRun, secondKind] = hasTrack ? [otherId, otherKind] : [id, kind];
  return {
    run: hasTrack ? id : otherId,
    hasTrack,
    second: { run: secondRun, corrected: secondKind === 'annotation' && id !== otherId },
    truth: null,
  };
}

/**
 * The tracks at a place: the one that opens by its name, and the other side's track with its overlap here.
 *
 * @param {Comparison} comparison
 * @param {Places} places
 * @param {{hasTrack: boolean, truth: string|null}} view   the view that the place opens
 * @param {number} index
 */
export function describeTracks(comparison, { side, tracks, partners }, { hasTrack, truth }, index) {
  const other = side === 'reference' ? 'candidate' : 'reference';
  /** @param {'reference'|'candidate'} whose @param {string} key */
  const nameOf = (whose, key) => comparison.sides[whose].names[key] ?? trackName(key);
  if (hasTrack) return nameOf(side, tracks[index]);
  const name = truth === null ? `${nameOf(side, tracks[index])} of the other run` : `truth ${tracks[index]}`;
  const partner = partners[index];
  return partner === null ? name : `${name}, ${nameOf(other, partner)}`;
}

/** Side of a crop, CSS px. */
const CROP_SIZE_PX = 64;

/**
 * The ground truth of a comparison and the run that can be corrected with it; null: no ground truth, or no run to correct.
 *
 * @param {Pick<Comparison, 'reference'|'candidate'>} found
 * @returns {{truth: string, side: 'reference'|'candidate', run: string}|null}
 */
function correctionTarget({ reference, candidate }) {
  const [[kind, id], [otherKind, otherId]] = [reference, candidate].map((name) => name.split(':'));
  if ((kind === 'truth') === (otherKind === 'truth')) return null;
  return kind === 'truth' ? { truth: id, side: 'reference', run: otherId } : { truth: otherId, side: 'candidate', run: id };
}

/**
 * The sign of the ground truth at a place; null: none.
 *
 * @param {Pick<Places, 'side'|'tracks'|'pairs'>} places
 * @param {'reference'|'candidate'} truthSide   side of the ground truth
 * @param {number} index
 * @returns {number|null}
 */
function signAt({ side: placeSide, tracks, pairs }, truthSide, index) {
  const key = placeSide === truthSide ? tracks[index] : pairs[index].other;
  return key === null ? null : Number(key.slice(1));
}

/**
 * @param {import('../page-types.js').App} app
 * @param {Comparison} comparison
 * @param {readonly import('../types.js').Label[]} labels
 * @param {() => void} onChange   called when the corrections of a side have changed
 * @returns {{element: HTMLElement, show: (places: Places) => void}}
 */
export function createPlaceList(app, comparison, labels, onChange) {
  const element = h('aside.compare-places', { 'aria-label': 'Frames behind a figure', tabIndex: -1 });
  fill(
    element,
    h('div.empty', icon('select'), h('h2', 'Places'), h('p', 'Choose a number to list the frames behind it. Each opens in the review.')),
  );

  /** @param {Places} shown */
  function show(shown) {
    const { title, side, frames, lasts, tracks, partners, pairs, places, errors } = shown;
    const view = reviewTarget(comparison, side);
    const { run, hasTrack } = view;
    const target = correctionTarget(comparison);
    const signs = target ? [...new Set(frames.map((_, index) => signAt(shown, target.side, index)).filter((sign) => sign !== null))] : [];
    /** @param {number[]} chosenSigns */
    const takeOverSigns = (chosenSigns) => target && takeOver(app, target.run, { truth: target.truth, signs: chosenSigns }, onChange);
    /** @param {number} index */
    function row(index) {
      const frame = frames[index];
      const pair = pairs[index];
      const sign = target && signAt(shown, target.side, index);
      const boxes = pair.other_box === null ? [pair.box] : [pair.box, pair.other_box];
      const region = cropRegion(boxes, comparison);
      const open = () => showInReview(app, run, view, { frame, box: boundingBox(boxes), sign });
      return h(
        'li.place-row',
        h(
          'a.place',
          {
            onclick: open,
            href: formatRoute({
              screen: 'review',
              video: comparison.video_id,
              run,
              frame,
              track: hasTrack ? tracks[index] : (partners[index] ?? pair.other),
            }),
          },
          crop(frame, region, side, pair),
          h(
            'span.stack.place-text',
            h(
              'span.row',
              h('span.place-frames', lasts[index] > frame ? `frames ${count(frame)}–${count(lasts[index])}` : `frame ${count(frame)}`),
              errors && h('span.place-error', { title: 'Error of this box' }, errors[index].toFixed(3)),
            ),
            h('span.small', describePair(comparison, side, pair, labels)),
            h('span.muted.small.truncate', describeTracks(comparison, shown, view, index)),
          ),
          icon('forward'),
        ),
        sign !== null &&
          h(
            'button.btn.btn-small',
            {
              title: `Take over sign ${sign} of the ground truth: all its boxes and its label`,
              'aria-label': `Take over sign ${sign} at frame ${count(frame)}`,
              onclick: () => takeOverSigns([sign]),
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
            { title: 'Take over the signs of all these places, in one step that can be undone', onclick: () => takeOverSigns(signs) },
            `Take over ${plural(signs.length, 'sign')}`,
          ),
      ),
      h('ol.places-list', ...frames.map((_, index) => row(index))),
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
    const boxElement = (one, whose) => h('span', { class: `place-box place-box-${whose}`, style: cssPosition(one, region) });
    return h(
      'span.place-crop',
      imageWithPlaceholder({
        src: app.api.framePartUrl(comparison.video_id, frame, region, CROP_SIZE_PX * 2),
        width: CROP_SIZE_PX,
        height: CROP_SIZE_PX,
        loading: 'lazy',
      }),
      boxElement(box, side),
      other && boxElement(other, side === 'reference' ? 'candidate' : 'reference'),
    );
  }

  return { element, show };
}

/** @param {readonly import('../types.js').Box[]} boxes @returns {import('../types.js').Box} */
const boundingBox = (boxes) => [
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
export function describePair({ confusion }, side, { label, other, other_label, iou }, labels) {
  /** @param {number|null} id */
  const name = (id) => confusion.words?.[String(id)] ?? labelName(labels, id);
  if (other === null) return `${name(label)}, no box of the ${side === 'reference' ? 'candidate' : 'reference'} on it`;
  const [a, b] = side === 'reference' ? [label, other_label] : [other_label, label];
  return `${a === b ? name(a) : `${name(a)} → ${name(b)}`}, IoU ${iou.toFixed(2)}`;
}
