// @ts-check
/** A merge of tracks with boxes in the same frames: shows both boxes and asks which ones to keep. */

import { docOf } from '../../editing/revisions.js';
import { clearestFrame } from '../../model/clearest.js';
import { engineName } from '../../model/labels.js';
import { trackEntries } from '../../model/track_entries.js';
import { trackName } from '../../model/track_name.js';
import { sharedFrames, describeSharedFrames, mergeTracks } from '../../operations/merge.js';
import { knownBox } from '../../review/known_box.js';
import { putOverlays } from '../../store/actions/review.js';
import { fill, h, setText } from '../dom.js';
import { count } from '../../model/format.js';
import { partOfFrame } from './two-versions.js';

/** @typedef {import('../../state-types.js').ReviewState} ReviewState */

/** Maximum number of pairs with a picture; the text counts the rest. */
const MOST = 3;

/**
 * The common frame nearest to a frame.
 * @param {readonly import('../../model/join.js').Span[]} runs
 * @param {number} frame
 */
export function nearestIn(runs, frame) {
  const near = runs.map(([first, last]) => Math.min(Math.max(frame, first), last));
  return near.reduce((best, one) => (Math.abs(one - frame) < Math.abs(best - frame) ? one : best));
}

/**
 * @param {import('./layer.js').Setup<'merge'>} setup
 * @returns {import('./layer.js').Content}
 */
export function mergeDialog({ app, data, close, signal }) {
  /** @type {string[]} */
  const marked = data.marked;
  let first = marked[0];
  const order = () => [first, ...marked.filter((key) => key !== first)];
  const pictures = h('div.stack');
  const choice = h(
    'fieldset.stack',
    h('legend', 'Keep the boxes of'),
    ...marked.map((key) => {
      const { review, labels } = app.store.get();
      const entry = review && trackEntries(review.tracks, review.docs).find((one) => one.key === key);
      return h(
        'label.row',
        h('input', {
          type: 'radio',
          name: 'merge-first',
          value: key,
          checked: key === first,
          onchange: () => {
            first = key;
            show();
          },
        }),
        h(
          'span.merge-name',
          { dir: 'auto' },
          `${trackName(key, review?.docs[key])} · ${engineName(labels, entry?.class_id, entry?.word ?? null)}`,
        ),
      );
    }),
  );
  const cancel = h('button.btn', { onclick: close }, 'Cancel');
  const go = h('button.btn.btn-primary', { type: 'submit' }, 'Merge');
  /** Frames that were requested. @type {Set<number>} */
  const asked = new Set();

  /** Load the boxes of a frame that are not in the store. @param {ReviewState} review @param {number} frame */
  async function fetchBoxes(review, frame) {
    const run = review.run?.id;
    if (!run || asked.has(frame)) return;
    asked.add(frame);
    try {
      const found = await app.api.overlays(run, frame, frame, { signal });
      if (app.store.get().review?.run?.id === run) app.store.dispatch(putOverlays, 'overlays', found);
    } catch {
      // without a picture, the text still names the frames
    }
  }

  function show() {
    const { review } = app.store.get();
    if (!review) return;
    const shared = sharedFrames(review, first, order().slice(1));
    fill(
      pictures,
      ...shared.slice(0, MOST).map((one) => {
        const doc = docOf(review, one.key);
        const frame = nearestIn(one.runs, (doc && clearestFrame(doc, review.tracks)) ?? review.frame);
        if (!review.overlays[frame]) void fetchBoxes(review, frame);
        const pair = /** @type {const} */ ([
          [one.stays[0], 'mine', 'stays'],
          [one.key, 'saved', 'goes'],
        ]);
        return h(
          'section.merge-pair',
          h('p', describeSharedFrames(review, one)),
          h(
            'div.row.two-versions',
            ...pair.map(([key, whose, fate]) =>
              partOfFrame(
                app,
                review.video,
                frame,
                [{ box: knownBox(review, key, frame), whose }],
                `Frame ${count(frame)}: the box of ${trackName(key, review.docs[key])} ${fate}`,
              ),
            ),
          ),
        );
      }),
      shared.length > MOST && h('p.muted.small', `${count(shared.length - MOST)} more tracks share frames.`),
    );
    setText(go, `Merge into ${trackName(first, review.docs[first])}`);
  }

  let drawn = app.store.get().review?.overlays;
  show();
  return {
    title: 'These tracks share frames',
    size: 'middle',
    focus: cancel,
    submit() {
      if (mergeTracks(app, first, order().slice(1))) close();
    },
    update({ review }) {
      if (review?.overlays === drawn) return;
      drawn = review?.overlays;
      show();
    },
    body: h(
      'div.stack',
      pictures,
      choice,
      h('p.muted.small', 'Two signs are two tracks: cancel if these are different signs. Undo reverts a merge.'),
    ),
    footer: [h('span.grow'), cancel, go],
  };
}
