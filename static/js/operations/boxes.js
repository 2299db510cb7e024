// @ts-check
/** Changing boxes and tracks. */

import { toast } from '../core/toast.js';
import { selectedDoc } from '../editing/revisions.js';
import { deletedTracks } from '../model/deleted.js';
import { labelOf } from '../model/effective.js';
import { normalizeBox, sizeOf } from '../model/geometry.js';
import { trackName } from '../model/track_name.js';
import { engineClass, shownTracks } from '../review/shown_tracks.js';
import { openDialog } from '../store/actions/page.js';
import { frameCount, select, setMode, applyTrackClick } from '../store/actions/review.js';
import { editSelected, needsBox, needsLoadedBoxes, needsRun, needsTrack, newKey, onReview, operation } from './helpers.js';
import { keyFramesAround, interpolate, keyFrameRemedy, missingKeyFrame, needsKeyFrames, setKeyFrame, toggleState } from './key_frames.js';
import { merge } from './merge.js';
import { createTrack, resizeSelectedBox, moveSelectedBox } from './place_box.js';

/** @typedef {import('../page-types.js').App} App */
/** @typedef {import('../state-types.js').State} State */

const GROUP = 'Boxes and tracks';

/**
 * The next track in the frame, from left to right; null after the last one, so that Tab continues through the page.
 * @param {State} state
 * @param {1|-1} direction
 * @returns {string|null}
 */
export function neighbour(state, direction) {
  const { review } = state;
  if (!review) return null;
  const keys = shownTracks(review)
    .sort((a, b) => a.box[0] - b.box[0])
    .map(({ key }) => key);
  const at = keys.indexOf(review.selected ?? '');
  return keys[at < 0 ? (direction > 0 ? 0 : keys.length - 1) : at + direction] ?? null;
}

/** @param {App} app @param {1|-1} direction */
function selectNeighbour(app, direction) {
  const key = neighbour(app.store.get(), direction);
  if (key !== null) app.store.dispatch(select, key);
}

const ARROWS = /** @type {const} */ ([
  ['Left', -1, 0, '←'],
  ['Right', 1, 0, '→'],
  ['Up', 0, -1, '↑'],
  ['Down', 0, 1, '↓'],
]);

/** A key that changes the selected box. @param {string} id @param {string} label @param {string} key @param {(app: App) => void} run */
const boxKey = (id, label, key, run) =>
  operation({ id: id.toLowerCase(), label, keys: [key], group: 'Box by keyboard', repeats: true, disabled: needsBox, run });

/** @type {import('../page-types.js').Operation[]} */
export const boxes = [
  operation({
    id: 'select-mode',
    label: 'Select and change boxes',
    short: 'Select',
    keys: ['Escape'],
    icon: 'select',
    group: GROUP,
    run: (app) => app.store.dispatch((state) => (state.review?.mode === 'select' ? select(state, null) : setMode(state, 'select'))),
  }),
  operation({
    id: 'draw',
    label: 'Draw a new track',
    short: 'Draw',
    keys: ['N'],
    icon: 'draw',
    group: GROUP,
    disabled: needsRun,
    tooltip: 'Drag a box and choose its class; with Shift held it corrects the selected track (N)',
    run: (app) => app.store.dispatch((state) => setMode(state, state.review?.mode === 'draw' ? 'select' : 'draw')),
  }),
  operation({
    id: 'merge',
    label: 'Merge tracks',
    short: 'Merge',
    keys: ['M'],
    icon: 'merge',
    group: GROUP,
    disabled: needsRun,
    tooltip: 'Press M, click the tracks in the picture, the lanes or the queue, press M again (M)',
    run: (app) => merge(app),
  }),
  operation({
    id: 'mark',
    label: 'Mark the selected track for the merge',
    keys: ['Enter'],
    group: 'Box by keyboard',
    tooltip: 'While merging: M, then Tab to a track and Enter to mark it, then M again (Enter)',
    available: (state) => onReview(state) && state.review?.mode === 'merge',
    disabled: needsTrack,
    run: (app) => app.store.dispatch((state) => (state.review?.selected ? applyTrackClick(state, state.review.selected) : state)),
  }),
  operation({
    id: 'split',
    label: 'Split the track here',
    short: 'Split',
    keys: ['Alt+M'],
    icon: 'split',
    group: GROUP,
    disabled: needsTrack,
    run: (app) => {
      const new_key = newKey();
      const { review } = app.store.get();
      const doc = selectedDoc(review);
      const class_id = review && doc ? labelOf(doc, (track) => engineClass(review, track)) : null;
      // the cursor is in the later half, and the next edit (another class, a verdict) is meant for that half
      if (editSelected(app, { name: 'split', new_key, class_id })) app.store.dispatch(select, new_key);
    },
  }),
  operation({
    id: 'key-frame',
    label: 'Set or remove a key frame',
    short: 'Key frame',
    keys: ['K'],
    icon: 'key',
    group: GROUP,
    tooltip: 'Keep this box, or release it. If the track has no box here, its nearest one is copied (K)',
    disabled: needsLoadedBoxes,
    run: (app) => setKeyFrame(app),
  }),
  operation({
    id: 'interpolate',
    label: 'Interpolate between key frames',
    short: 'Interpolate',
    keys: ['I'],
    icon: 'interpolate',
    group: GROUP,
    tooltip: 'Boxes on a straight line between the key frames around the cursor, or no longer (I)',
    disabled: (state) => needsTrack(state) ?? (keyFramesAround(state) ? null : needsKeyFrames(missingKeyFrame(state))),
    remedy: keyFrameRemedy,
    run: (app) => interpolate(app),
  }),
  operation({
    id: 'outside',
    label: 'Outside from here on',
    short: 'Outside',
    keys: ['O'],
    icon: 'outside',
    group: GROUP,
    disabled: needsTrack,
    run: (app) => toggleState(app, 'set_outside', 'outside'),
  }),
  operation({
    id: 'occluded',
    label: 'Occluded from here on',
    short: 'Occluded',
    keys: ['Q'],
    icon: 'occluded',
    group: GROUP,
    disabled: needsBox,
    run: (app) => toggleState(app, 'set_occluded', 'occluded'),
  }),
  operation({
    id: 'delete-from',
    label: 'Delete from here on',
    short: 'Delete from here',
    keys: ['Del'],
    icon: 'cut',
    group: GROUP,
    disabled: needsTrack,
    tooltip: 'Delete from here on (Del); keep this frame as the last one (Alt+Del)',
    run: (app) => editSelected(app, { name: 'delete_from' }),
  }),
  operation({
    id: 'end-here',
    label: 'End the track with this frame',
    keys: ['Alt+Del'],
    group: GROUP,
    disabled: (state) =>
      needsTrack(state) ??
      (state.review && state.review.frame < frameCount(state.review) - 1 ? null : 'This is the last frame of the video.'),
    run: (app) => editSelected(app, { name: 'delete_from', frame: (app.store.get().review?.frame ?? 0) + 1 }),
  }),
  operation({
    id: 'delete-track',
    label: 'Delete the whole track',
    short: 'Whole track',
    keys: ['Shift+Del'],
    icon: 'delete',
    group: GROUP,
    disabled: needsTrack,
    run: (app) => {
      const { review } = app.store.get();
      const key = review?.selected ?? '';
      const name = trackName(key, review?.docs[key]);
      if (!editSelected(app, { name: 'delete_track' })) return;
      app.store.dispatch(select, null);
      toast(`Track ${name} is deleted, with all its boxes.`, {
        topic: 'undo',
        action: { label: 'Undo', run: () => void app.editor.undo() },
      });
    },
  }),
  operation({
    id: 'deleted-tracks',
    label: 'Deleted tracks',
    keys: [],
    group: GROUP,
    tooltip: 'List the deleted tracks and restore them',
    disabled: (state) => (state.review && deletedTracks(state.review.docs).length ? null : 'No track is deleted.'),
    run: (app) => app.store.dispatch(openDialog, { kind: 'deleted' }),
  }),
  operation({
    id: 'next-track',
    label: 'Next track in this frame',
    keys: ['Tab'],
    group: GROUP,
    repeats: true,
    run: (app) => selectNeighbour(app, 1),
  }),
  operation({
    id: 'previous-track',
    label: 'Previous track in this frame',
    keys: ['Shift+Tab'],
    group: GROUP,
    repeats: true,
    run: (app) => selectNeighbour(app, -1),
  }),
  ...ARROWS.flatMap(([name, dx, dy, arrow]) => [
    boxKey(`move-${name}`, `Move the box ${arrow}`, `Arrow${name}`, (app) => moveSelectedBox(app, dx, dy)),
    boxKey(`move-10-${name}`, `Move the box 10 px ${arrow}`, `Shift+Arrow${name}`, (app) => moveSelectedBox(app, 10 * dx, 10 * dy)),
    boxKey(`grow-${name}`, `Resize the box ${arrow}`, `Alt+Arrow${name}`, (app) => resizeSelectedBox(app, dx, dy)),
  ]),
  operation({
    id: 'new-box',
    label: 'New track in the middle of the view',
    short: 'New track',
    keys: ['Shift+N'],
    icon: 'new_box',
    group: 'Box by keyboard',
    disabled: needsRun,
    run: (app) => {
      const { review } = app.store.get();
      if (!review) return;
      const { x, y, zoom } = review.viewport;
      const halfHeight = Math.max(12, 24 / Math.max(zoom, 0.1));
      const halfWidth = halfHeight / (review.viewport.stretch ?? 1);
      const box = normalizeBox([x - halfWidth, y - halfHeight, x + halfWidth, y + halfHeight], sizeOf(review.video));
      createTrack(app, { key: newKey(), frame: review.frame, box }, null);
    },
  }),
];
