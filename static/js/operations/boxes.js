// @ts-check
/** Changing boxes and tracks. */

import { docOf } from '../editing/revisions.js';
import { deletedTracks } from '../model/deleted.js';
import { keyFramesOf } from '../model/documents.js';
import { labelOf, shownSpan } from '../model/effective.js';
import { nudged, settled, sizeOf } from '../model/geometry.js';
import { trackName } from '../model/track_name.js';
import { knownBox } from '../review/known_box.js';
import { nearestBox } from '../review/nearest_box.js';
import { engineClass, shownTrack, shownTracks } from '../review/shown_tracks.js';
import { openDialog } from '../store/actions/page.js';
import { askForClass, framesOf, seek, select, setMode, setPlaying, toggleMarked } from '../store/actions/review.js';
import { toast } from '../views/toasts.js';
import { editSelected, needsBox, needsBoxes, needsRun, needsTrack, newKey, onReview, operation } from './helpers.js';
import { merge } from './merge.js';
import { editTelling } from './unseen.js';

/** @typedef {import('../page-types.js').App} App */
/** @typedef {import('../state-types.js').State} State */

const GROUP = 'Boxes and tracks';

/** @param {State} state */
const size = (state) => sizeOf(state.review?.video);

/** The state that holds at the cursor. @param {State} state @param {'occluded'|'outside'} what */
function holds(state, what) {
  const { review } = state;
  const doc = review?.selected ? review.docs[review.selected] : undefined;
  if (!doc || !review) return false;
  const before = keyFramesOf(doc).findLast((k) => k <= review.frame);
  return before === undefined ? false : doc.keys[before][what];
}

/**
 * Say something of the selected track from here on. A box of the engine stays the engine's: only one that people have drawn,
 * or that lies on a line between two such, is pinned here.
 *
 * @param {App} app
 * @param {'set_occluded'|'set_outside'} name
 * @param {'occluded'|'outside'} what
 */
function toggle(app, name, what) {
  const state = app.store.get();
  const shown = state.review?.selected ? shownTrack(state.review, state.review.selected) : null;
  const box = shown === null || shown.origin === 'engine' ? null : shown.box;
  editSelected(app, { name, value: !holds(state, what), box });
}

/** The two corrected key frames around the cursor. @param {State} state @returns {[number, number]|null} */
function around(state) {
  const { review } = state;
  const doc = review?.selected ? review.docs[review.selected] : undefined;
  if (!doc || !review) return null;
  const frames = keyFramesOf(doc).filter((k) => doc.keys[k].box !== null);
  const first = frames.findLast((k) => k <= review.frame) ?? frames[0];
  const last = frames.find((k) => k > review.frame) ?? frames.at(-1);
  if (first === undefined || last === undefined) return null;
  if (first < last) return [first, last];
  const earlier = frames.at(-2);
  return earlier === undefined ? null : [earlier, last];
}

/**
 * Keep the box of the cursor's frame, or let it go. Out of the track's frames its nearest box is copied here, and told.
 * @param {Pick<App, 'store'|'edit'> & Partial<Pick<App, 'editor'>>} app
 * @param {import('./unseen.js').Say} [say]
 */
export function setKeyFrame(app, say = toast) {
  const { review } = app.store.get();
  if (!review?.selected) return;
  const doc = docOf(review, review.selected);
  const shown = shownTrack(review, review.selected);
  const nearest = shown ? null : nearestBox(review, review.selected);
  if (shown && doc?.keys[review.frame]) editSelected(app, { name: 'remove_key' });
  else if (shown) editSelected(app, { name: 'add_key', box: shown.box });
  else if (nearest) {
    const box = settled(nearest.box, size(app.store.get()));
    editTelling(app, review.selected, () => editSelected(app, { name: 'set_box', box }), { copied: nearest.frame, say });
  }
}

/**
 * Lay boxes on a line between two key frames, or take them off it. A drawn track has such lines from the beginning, so what
 * has happened is said.
 *
 * @param {Pick<App, 'store'|'edit'> & Partial<Pick<App, 'editor'>>} app
 * @param {import('./unseen.js').Say} [say]
 */
export function interpolate(app, say = toast) {
  const state = app.store.get();
  const range = around(state);
  const key = state.review?.selected;
  const doc = key ? state.review?.docs[key] : undefined;
  if (!range || !key || !doc) return;
  const [first, last] = range;
  const value = !doc.keys[first].interpolate;
  const without = doc.segments.length ? 'The engine’s boxes stand again' : 'There are no boxes any more';
  const said = value ? `Boxes lie on a line between frames ${first} and ${last}.` : `${without} between frames ${first} and ${last}; press I again for the line.`;
  editTelling(app, key, () => editSelected(app, { name: 'interpolate', first, last, value }), { said, say });
}

/**
 * What a line between key frames lacks: a key frame here, or, where the only one is here, at the other end of the track.
 * @param {State} state
 * @returns {number|null} its frame; null: nothing is lacking, or there is no such frame
 */
export function lackingKey(state) {
  const { review } = state;
  if (needsTrack(state) !== null || !review?.selected || around(state)) return null;
  const doc = docOf(review, review.selected);
  if (!doc?.keys[review.frame]?.box) return review.frame;
  const span = shownSpan(doc, review.tracks);
  return span === null || span.first === span.last ? null : review.frame < span.last ? span.last : span.first;
}

/**
 * Go to the frame that lacks a key frame and set it.
 * @param {Pick<App, 'store'|'edit'> & Partial<Pick<App, 'editor'>>} app
 * @param {import('./unseen.js').Say} [say]
 */
export function setLackingKey(app, say = toast) {
  const state = app.store.get();
  const frame = lackingKey(state);
  const key = state.review?.selected;
  if (frame === null || !key || !state.review) return;
  const box = knownBox(state.review, key, frame);
  if (frame !== state.review.frame) app.store.dispatch((now) => seek(setPlaying(now, false), frame));
  const why = needsBoxes(app.store.get());
  if (box) app.edit({ name: 'add_key', key, frame, box });
  else if (why) say(`${why} Then press K.`, { topic: 'unseen' });
  else setKeyFrame(app, say);
}

/**
 * The next track in the frame, from left to right; null behind the last one, so that Tab goes on through the page.
 * @param {State} state
 * @param {1|-1} direction
 * @returns {string|null}
 */
export function neighbour(state, direction) {
  const { review } = state;
  if (!review) return null;
  const keys = shownTracks(review).map(({ key, box }) => ({ key, x: box[0] })).sort((a, b) => a.x - b.x).map(({ key }) => key);
  const at = keys.indexOf(review.selected ?? '');
  return keys[at < 0 ? (direction > 0 ? 0 : keys.length - 1) : at + direction] ?? null;
}

/** @param {App} app @param {1|-1} direction */
function cycle(app, direction) {
  const key = neighbour(app.store.get(), direction);
  if (key !== null) app.store.dispatch((state) => select(state, key));
}

/**
 * A person has placed a box. Of a track that is being followed it is one more anchor, and nothing is stored until the
 * proposals are accepted; else it is an edit.
 * @param {Pick<App, 'store'|'edit'|'following'>} app
 * @param {string} key
 * @param {number} frame
 * @param {import('../types.js').Box} box
 * @param {string} [gesture]
 * @param {import('./unseen.js').Say} [say]
 */
export function putBox(app, key, frame, box, gesture, say = toast) {
  if (app.store.get().review?.following?.key === key) app.following.correct({ frame, box });
  else editTelling(app, key, () => app.edit({ name: 'set_box', frame, key, box }, undefined, gesture), { say });
}

/** @param {App} app @param {number} dx @param {number} dy */
function nudge(app, dx, dy) {
  const state = app.store.get();
  const shown = state.review?.selected ? shownTrack(state.review, state.review.selected) : null;
  if (shown && state.review) putBox(app, shown.key, state.review.frame, nudged(shown.box, dx, dy, size(state)), 'move');
}

/** Right and lower edge move; the rest stays. @param {App} app @param {number} dx @param {number} dy */
function grow(app, dx, dy) {
  const state = app.store.get();
  const shown = state.review?.selected ? shownTrack(state.review, state.review.selected) : null;
  if (!shown || !state.review) return;
  const [x1, y1, x2, y2] = shown.box;
  putBox(app, shown.key, state.review.frame, settled([x1, y1, Math.max(x1 + 2, x2 + dx), Math.max(y1 + 2, y2 + dy)], size(state)), 'resize');
}

/** @param {number|null} frame   that could be made one */
export const needsKeys = (frame) => `Needs a key frame before and after.${frame === null ? '' : ` Set one at frame ${frame}?`}`;

/** @param {App} app */
export const keyRemedy = (app) => (lackingKey(app.store.get()) === null ? null : { label: 'Set key frame', run: () => setLackingKey(app) });

const ARROWS = /** @type {const} */ ([['Left', -1, 0, '←'], ['Right', 1, 0, '→'], ['Up', 0, -1, '↑'], ['Down', 0, 1, '↓']]);

/** @type {import('../page-types.js').Operation[]} */
export const boxes = [
  operation({
    id: 'select-mode', label: 'Select and change boxes', short: 'Select', keys: ['Escape'], icon: 'select', group: GROUP,
    run: (app) => app.store.dispatch((state) => (state.review?.mode === 'select' ? select(state, null) : setMode(state, 'select'))),
  }),
  operation({
    id: 'draw', label: 'Draw a new track', short: 'Draw', keys: ['N'], icon: 'draw', group: GROUP, disabled: needsRun,
    tooltip: 'Drag a box and choose its class; with Shift held it corrects the selected track (N)',
    run: (app) => app.store.dispatch((state) => setMode(state, state.review?.mode === 'draw' ? 'select' : 'draw')),
  }),
  operation({
    id: 'merge', label: 'Merge tracks', short: 'Merge', keys: ['M'], icon: 'merge', group: GROUP, disabled: needsRun,
    tooltip: 'Press M, click the tracks in the picture, the lanes or the queue, press M again (M)', run: (app) => merge(app),
  }),
  operation({
    id: 'mark', label: 'Mark the selected track for the merge', keys: ['Enter'], group: 'Box by keyboard',
    tooltip: 'While merging: M, then Tab to a track and Enter to mark it, then M again (Enter)',
    available: (state) => onReview(state) && state.review?.mode === 'merge', disabled: needsTrack,
    run: (app) => app.store.dispatch((state) => (state.review?.selected ? toggleMarked(state, state.review.selected) : state)),
  }),
  operation({
    id: 'split', label: 'Split the track here', short: 'Split', keys: ['Alt+M'], icon: 'split', group: GROUP, disabled: needsTrack,
    run: (app) => {
      const new_key = newKey();
      const { review } = app.store.get();
      const doc = review?.selected ? docOf(review, review.selected) : null;
      const class_id = review && doc ? labelOf(doc, (track) => engineClass(review, track)) : null;
      // the cursor stands in the later half, and what comes next (another class, a verdict) is meant for it
      if (editSelected(app, { name: 'split', new_key, class_id })) app.store.dispatch((state) => select(state, new_key));
    },
  }),
  operation({
    id: 'key-frame', label: 'Set or remove a key frame', short: 'Key frame', keys: ['K'], icon: 'key', group: GROUP,
    tooltip: 'Keep this box, or let it go; where the track has no box, its nearest one is carried here (K)', disabled: needsBoxes,
    run: (app) => {
      setKeyFrame(app);
    },
  }),
  operation({
    id: 'interpolate', label: 'Interpolate between key frames', short: 'Interpolate', keys: ['I'], icon: 'interpolate', group: GROUP,
    tooltip: 'Boxes on a straight line between the key frames around the cursor, or not any more (I)',
    disabled: (state) => needsTrack(state) ?? (around(state) ? null : needsKeys(lackingKey(state))),
    remedy: keyRemedy,
    run: (app) => interpolate(app),
  }),
  operation({
    id: 'outside', label: 'Outside from here on', short: 'Outside', keys: ['O'], icon: 'outside', group: GROUP, disabled: needsTrack,
    run: (app) => toggle(app, 'set_outside', 'outside'),
  }),
  operation({
    id: 'occluded', label: 'Occluded from here on', short: 'Occluded', keys: ['Q'], icon: 'occluded', group: GROUP, disabled: needsBox,
    run: (app) => toggle(app, 'set_occluded', 'occluded'),
  }),
  operation({
    id: 'delete-from', label: 'Delete from here on', short: 'Delete on', keys: ['Del'], icon: 'cut', group: GROUP, disabled: needsTrack,
    tooltip: 'Delete from here on (Del); keep this frame as the last one (Alt+Del)',
    run: (app) => editSelected(app, { name: 'delete_from' }),
  }),
  operation({
    id: 'end-here', label: 'End the track with this frame', keys: ['Alt+Del'], group: GROUP,
    disabled: (state) => needsTrack(state) ?? (state.review && state.review.frame < framesOf(state.review) - 1 ? null : 'This is the last frame of the video.'),
    run: (app) => editSelected(app, { name: 'delete_from', frame: (app.store.get().review?.frame ?? 0) + 1 }),
  }),
  operation({
    id: 'delete-track', label: 'Delete the whole track', short: 'Delete track', keys: ['Shift+Del'], icon: 'delete', group: GROUP, disabled: needsTrack,
    run: (app) => {
      const { review } = app.store.get();
      const key = review?.selected ?? '';
      const name = trackName(key, review?.docs[key]);
      if (!editSelected(app, { name: 'delete_track' })) return;
      app.store.dispatch((state) => select(state, null));
      toast(`Track ${name} is deleted, with all its boxes.`, { topic: 'undo', action: { label: 'Undo', run: () => void app.editor.undo() } });
    },
  }),
  operation({
    id: 'deleted-tracks', label: 'Deleted tracks', keys: [], group: GROUP, tooltip: 'What was deleted, with a way back',
    disabled: (state) => (state.review && deletedTracks(state.review.docs).length ? null : 'No track is deleted.'),
    run: (app) => app.store.dispatch((state) => openDialog(state, { kind: 'deleted' })),
  }),
  operation({ id: 'next-track', label: 'Next track in this frame', keys: ['Tab'], group: GROUP, repeats: true, run: (app) => cycle(app, 1) }),
  operation({ id: 'previous-track', label: 'Previous track in this frame', keys: ['Shift+Tab'], group: GROUP, repeats: true, run: (app) => cycle(app, -1) }),
  ...ARROWS.flatMap(([name, dx, dy, arrow]) => [
    operation({ id: `move-${name.toLowerCase()}`, label: `Move the box ${arrow}`, keys: [`Arrow${name}`], group: 'Box by keyboard', repeats: true, disabled: needsBox, run: (app) => nudge(app, dx, dy) }),
    operation({ id: `move-10-${name.toLowerCase()}`, label: `Move the box 10 px ${arrow}`, keys: [`Shift+Arrow${name}`], group: 'Box by keyboard', repeats: true, disabled: needsBox, run: (app) => nudge(app, 10 * dx, 10 * dy) }),
    operation({ id: `grow-${name.toLowerCase()}`, label: `Resize the box ${arrow}`, keys: [`Alt+Arrow${name}`], group: 'Box by keyboard', repeats: true, disabled: needsBox, run: (app) => grow(app, dx, dy) }),
  ]),
  operation({
    id: 'new-box', label: 'New track in the middle of the view', short: 'New box', keys: ['Shift+N'], icon: 'new_box', group: 'Box by keyboard', disabled: needsRun,
    run: (app) => {
      const { review } = app.store.get();
      if (!review) return;
      const { x, y, zoom } = review.viewport;
      const half = Math.max(12, 24 / Math.max(zoom, 0.1));
      const wide = half / (review.viewport.stretch ?? 1);
      create(app, { key: newKey(), frame: review.frame, box: settled([x - wide, y - half, x + wide, y + half], size(app.store.get())) }, null);
    },
  }),
];

/** A box was drawn. @param {Pick<App, 'store'|'edit'|'following'>} app @param {import('../types.js').Box} box @param {boolean} correct   the selected track instead of a new one @param {import('./unseen.js').Say} [say] */
export function drawn(app, box, correct, say = toast) {
  const { review } = app.store.get();
  if (!review) return;
  if (correct && review.selected) {
    putBox(app, review.selected, review.frame, box, undefined, say);
    app.store.dispatch((state) => setMode(state, 'select'));
    return;
  }
  app.store.dispatch((state) => askForClass(state, { key: newKey(), frame: review.frame, box }));
}

/**
 * Make a drawn box a track.
 * @param {Pick<App, 'store'|'edit'>} app
 * @param {import('../state-types.js').Draft} draft
 * @param {number|null} class_id   null: of none of the known classes
 * @param {string} [label_key]     of that label
 */
export function create(app, { key, frame, box }, class_id, label_key) {
  if (app.edit({ name: 'create_track', frame, key, box, class_id, ...(label_key !== undefined && { label_key }) })) app.store.dispatch((state) => select(state, key));
}
