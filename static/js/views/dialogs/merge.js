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
import { createFrameCrop } from './two_versions.js';

/** @typedef {import('../../state-types.js').ReviewState} ReviewState */

/** Maximum number of pairs with a picture; the text counts the rest. */
const MAX_PAIRS = 3;

/**
 * The common frame nearest to a frame.
 * @param {readonly import('../../model/join.js').Span[]} runs
 * @param {number} frame
 */
export function nearestFrame(runs, frame) {
  const candidates = runs.map(([first, last]) => Math.min(Math.max(frame, first), last));
  return candidates.reduce((best, one) => (Math.abs(one - frame) < Math.abs(best - frame) ? one : best));
}

/** @type {import('./index.js').CreateDialog<'merge'>} */
export function mergeDialog({ app, data, close, signal }) {
  /** @type {string[]} */ const keys = data.marked;
  let keptKey = keys[0];
  const orderedKeys = () => [keptKey, ...keys.filter((key) => key !== keptKey)];
  const pictures = h('div.stack');
  const choice = h(
    'fieldset.stack',
    h('legend', 'Keep the boxes of'),
    ...keys.map((key) => {
      const { review, labels } = app.store.get();
      const entry = review && trackEntries(review.tracks, review.docs).find((one) => one.key === key);
      return h(
        'label.row',
        h('input', {
          type: 'radio',
          name: 'merge-first',
          value: key,
          checked: key === keptKey,
          onchange: () => {
            keptKey = key;
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
  const cancelButton = h('button.btn', { onclick: close }, 'Cancel');
  const submitButton = h('button.btn.btn-primary', { type: 'submit' }, 'Merge');
  /** Frames that were requested. @type {Set<number>} */
  const requestedFrames = new Set();

  /** Load the boxes of a frame that are not in the store. @param {ReviewState} review @param {number} frame */
  async function fetchBoxes(review, frame) {
    const run = review.run?.id;
    if (!run || requestedFrames.has(frame)) return;
    requestedFrames.add(frame);
    try {
      const overlays = await app.api.overlays(run, frame, frame, { signal });
      if (app.store.get().review?.run?.id === run) app.store.dispatch(putOverlays, 'overlays', overlays);
    } catch {
      // without a picture, the text still names the frames
    }
  }

  function show() {
    const { review } = app.store.get();
    if (!review) return;
    const shared = sharedFrames(review, keptKey, orderedKeys().slice(1));
    fill(
      pictures,
      ...shared.slice(0, MAX_PAIRS).map((overlap) => {
        const doc = docOf(review, overlap.key);
        const frame = nearestFrame(overlap.runs, (doc && clearestFrame(doc, review.tracks)) ?? review.frame);
        if (!review.overlays[frame]) void fetchBoxes(review, frame);
        const pair = /** @type {const} */ ([
          [overlap.stays[0], 'mine', 'stays'],
          [overlap.key, 'saved', 'goes'],
        ]);
        return h(
          'section.merge-pair',
          h('p', describeSharedFrames(review, overlap)),
          h(
            'div.row.two-versions',
            ...pair.map(([key, version, outcome]) =>
              createFrameCrop(
                app,
                review.video,
                frame,
                [{ box: knownBox(review, key, frame), version }],
                `Frame ${count(frame)}: the box of ${trackName(key, review.docs[key])} ${outcome}`,
              ),
            ),
          ),
        );
      }),
      shared.length > MAX_PAIRS && h('p.muted.small', `${count(shared.length - MAX_PAIRS)} more tracks share frames.`),
    );
    setText(submitButton, `Merge into ${trackName(keptKey, review.docs[keptKey])}`);
  }

  let drawnOverlays = app.store.get().review?.overlays;
  show();
  return {
    title: 'These tracks share frames',
    size: 'middle',
    focus: cancelButton,
    submit() {
      if (mergeTracks(app, keptKey, orderedKeys().slice(1))) close();
    },
    update({ review }) {
      if (review?.overlays === drawnOverlays) return;
      drawnOverlays = review?.overlays;
      show();
    },
    body: h(
      'div.stack',
      pictures,
      choice,
      h('p.muted.small', 'Two signs are two tracks: cancel if these are different signs. Undo reverts a merge.'),
    ),
    footer: [h('span.grow'), cancelButton, submitButton],
  };
}
