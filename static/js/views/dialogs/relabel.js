// @ts-check
/** Choose a label by typing part of its name, its code or its number, or add a label. Works by keyboard alone. */

import { errorMessage } from '../../api/errors.js';
import { NO_CLASS } from '../../model/documents.js';
import { labelAt, labelOf } from '../../model/effective.js';
import { toScreen } from '../../model/geometry.js';
import { labelFinder } from '../../model/label_finder.js';
import { labelName, offeredLabels, resolveLabelId } from '../../model/labels.js';
import { documentLane, lastVotes } from '../../model/track_lane.js';
import { trackName } from '../../model/track_name.js';
import { createTrack } from '../../operations/place_box.js';
import { followDrawn } from '../../operations/follow.js';
import { labelSetKey } from '../../editing/label_sets.js';
import { judge } from '../../operations/verdicts.js';
import { docOf } from '../../editing/revisions.js';
import { shownTrack } from '../../review/shown_tracks.js';
import { editTrack } from '../edit_track.js';
import { h, setText } from '../dom.js';
import { percent } from '../../model/format.js';
import { recall, remember } from '../../core/preferences.js';
import { addRecentLabel, labelIdOfKey, recentLabelIds } from '../recent_labels.js';
import { createLabelPicker } from './label_picker.js';

/** @typedef {import('../../types.js').Label} Label */

/**
 * The labels in their order before any typing: some come first, the rest keep their order.
 *
 * @param {readonly Label[]} labels
 * @param {readonly (number|null|undefined)[]} firstIds   their ids; unknown ids are ignored
 * @returns {Label[]}
 */
export function reordered(labels, firstIds) {
  return [...new Set([...firstIds.flatMap((id) => labels.find((label) => label.id === id) ?? []), ...labels])];
}

/**
 * The engine's leading classes of a track with their shares of the votes, largest first.
 *
 * @param {Pick<import('../../types.js').TrackLane, 'classes'|'votes'>|null|undefined} lane   null: not loaded, or the engine has none
 * @returns {Map<number, number>} class -> share; small shares too, because the true class of a confidently misread sign has a small share
 */
export function voteShares(lane) {
  const shares = (lane && lastVotes(lane)) ?? [];
  const shareByClass = shares.map((share, i) => /** @type {[number, number]} */ ([Number(lane?.classes[i]), share]));
  return new Map(shareByClass.filter(([, share]) => share > 0).sort(([, a], [, b]) => b - a));
}

/**
 * Whether people have already set this label, so that there is nothing to store.
 *
 * @param {import('../../types.js').TrackDoc} doc
 * @param {number|null} frame       frame of a single box; null: the whole track
 * @param {number|null} class_id
 */
export function isAlreadySet(doc, frame, class_id) {
  if (frame !== null) return (doc.keys[frame]?.class_id ?? null) === class_id;
  return doc.class_id === class_id && Object.values(doc.keys).every((key) => key.class_id === null);
}

/**
 * The side of the window on which the dialog does not cover the sign.
 *
 * @param {import('../../state-types.js').ReviewState|null} review
 * @param {import('../../types.js').Box|null} box
 * @param {{left: number, width: number, height: number}|undefined} stage   the picture in the window
 * @param {number} windowWidth
 * @returns {'left'|'right'|undefined}
 */
export function sideBesideBox(review, box, stage, windowWidth) {
  if (!review || !box || !stage) return undefined;
  const [x] = toScreen(review.viewport, stage, (box[0] + box[2]) / 2, 0);
  return stage.left + x < windowWidth / 2 ? 'right' : 'left';
}

/**
 * The last row of the list, for a text that names none of the labels on offer.
 *
 * @param {readonly Label[]} labels   the whole set
 * @param {string} text
 * @returns {{text: string, hidden: Label|null}|null} hidden: the label that it names, if that is only hidden
 */
export function unmatchedTextRow(labels, text) {
  if (text === '' || text.startsWith('#')) return null;
  const match = labelFinder(labels).find(text);
  if (match === null || match.how === 'number') return { text: `Add '${text}'`, hidden: null };
  return match.label.hidden ? { text: `'${match.label.name}' is hidden: show it again and use it`, hidden: match.label } : null;
}

/** @type {import('./index.js').CreateDialog<'relabel'>} */
export function relabelDialog({ app, data, close, signal }) {
  const { review } = app.store.get();
  /** @type {import('../../state-types.js').Draft|null} */ const draft = data.draft ?? null;
  /** @type {string|null} */ const key = draft ? null : (data.key ?? review?.selected ?? null);
  const frame = draft?.frame ?? data.frame ?? review?.frame ?? 0;
  const doc = review && key ? docOf(review, key) : null;
  /** @param {number} id */
  const engineClass = (id) => review?.tracks?.class_id[review.tracks.id.indexOf(id)] ?? null;
  const votes = voteShares(review && key ? documentLane(key, review.docs[key], review.laneOf)?.lane : null);
  let { labels } = app.store.get();
  let setKey = labelSetKey(app.store.get());
  /** Whether the key that is handled now also accepts the track. */
  let acceptsTrack = false;
  const boxRadio = h('input', {
    type: 'radio',
    name: 'scope',
    id: 'scope-box',
    checked: data.scope === 'box',
    onchange: () => updateResetButton(),
  });
  const trackRadio = h('input', {
    type: 'radio',
    name: 'scope',
    id: 'scope-track',
    checked: data.scope !== 'box',
    onchange: () => updateResetButton(),
  });
  const scopeFields = h(
    'fieldset.row.scopes',
    { hidden: draft !== null },
    h('legend.visually-hidden', 'What gets the label'),
    h('label.row', trackRadio, 'Whole track'),
    h('label.row', boxRadio, `Only the box at frame ${frame}`),
  );
  const errorText = h('p.field-error', { role: 'alert' });
  const picker = createLabelPicker({
    onPick: choose,
    placeholder: 'Type a name, a code or a number',
    noteAfterName: ({ id }) => ((votes.get(id) ?? 0) >= 0.005 ? percent(votes.get(id)) : ''),
    furtherRow: (text) => {
      const row = unmatchedTextRow(labels, text);
      return (
        row && { text: row.text, run: () => void changeSet(row.hidden ? { type: 'show', id: row.hidden.id } : { type: 'add', name: text }) }
      );
    },
  });

  /** Offer the labels again after a change of the set. */
  function offerLabels() {
    labels = app.store.get().labels;
    setKey = labelSetKey(app.store.get());
    const ids = draft
      ? [labelIdOfKey(labels, recall('draw.label')), ...recentLabelIds(labels)]
      : [
          resolveLabelId(labels, doc && labelAt(doc, frame, engineClass)),
          ...[...votes.keys()].map((id) => resolveLabelId(labels, id)),
          ...recentLabelIds(labels),
        ];
    const ordered = reordered(offeredLabels(labels), ids);
    // put the track's present label first; for none of the labels nothing is marked, because Enter would take it
    picker.offer(
      labels,
      ordered,
      Math.max(
        draft ? 0 : -1,
        ordered.findIndex(({ id }) => id === ids[0]),
      ),
    );
    updateResetButton();
  }

  /** Change the set, then assign the changed label. @param {import('../../types.js').LabelChange} labelChange */
  async function changeSet(labelChange) {
    const accepts = acceptsTrack;
    picker.search.readOnly = true;
    setText(errorText, '');
    try {
      const { label } = await app.labels.change(labelChange, setKey);
      if (signal.aborted) return;
      if (label !== null) choose(label, accepts);
    } catch (thrown) {
      if (signal.aborted) return;
      setText(errorText, errorMessage(thrown));
      offerLabels();
    } finally {
      picker.search.readOnly = false;
    }
  }

  /** @param {Label} label @param {boolean} [accepts]   whether the track is accepted together with the label */
  function choose(label, accepts = acceptsTrack) {
    addRecentLabel(label);
    if (draft) remember('draw.label', label.key);
    applyLabel(label.id, label.key, accepts);
  }

  /** @param {number|null} class_id @param {string} [label_key]   key of the chosen label, because the set may change @param {boolean} [accepts] */
  function applyLabel(class_id, label_key, accepts = false) {
    const now = app.store.get().review;
    const currentDoc = now && key ? docOf(now, key) : null;
    if (draft) {
      createTrack(app, draft, class_id, label_key);
      followDrawn(app, draft);
    } else if (key && !(currentDoc && isAlreadySet(currentDoc, boxRadio.checked ? frame : null, class_id)))
      editTrack(app, key, {
        name: boxRadio.checked ? 'relabel_box' : 'relabel_track',
        class_id,
        frame,
        ...(label_key !== undefined && { label_key }),
      });
    close();
    if (accepts && key && app.store.get().review?.selected === key) judge(app, 'accepted');
  }

  /** The button that removes a label: a box then has its track's label, a track the engine's. */
  function updateResetButton() {
    const [text, id] = boxRadio.checked
      ? ['As the whole track', doc && labelOf(doc, engineClass)]
      : ['As read by the engine', doc && labelOf({ ...doc, class_id: null }, engineClass)];
    setText(resetButton, text);
    resetButton.title = `${text}: ${labelName(labels, id)}`;
    resetButton.hidden = !boxRadio.checked && !doc?.key.startsWith('m') && !doc?.segments.length;
  }

  // in the capture phase, before the list takes the label
  picker.search.addEventListener(
    'keydown',
    (event) => {
      acceptsTrack = event.key === 'Enter' && (event.ctrlKey || event.metaKey) && draft === null;
    },
    { capture: true },
  );
  picker.search.addEventListener('keydown', (event) => {
    acceptsTrack = false; // the list has handled the key; a later click takes the label only
    if (event.altKey && event.key.toLowerCase() === 'b') {
      event.preventDefault();
      (boxRadio.checked ? trackRadio : boxRadio).checked = true;
      updateResetButton();
    }
  });
  if (!draft) picker.onEnter(close);
  const notInSetButton = h(
    'button.btn',
    { title: 'A sign without a label in the set', onclick: () => applyLabel(NO_CLASS) },
    'Not in the set',
  );
  const resetButton = h('button.btn', { onclick: () => applyLabel(null) });
  offerLabels();
  picker.reveal();
  return {
    side: sideBesideBox(
      review,
      draft?.box ?? (review && key ? shownTrack(review, key)?.box : null) ?? null,
      document.querySelector('.picture-stage')?.getBoundingClientRect(),
      innerWidth,
    ),
    title: key ? `Relabel track ${trackName(key, review?.docs[key])}` : 'Label of the new track',
    size: 'middle',
    focus: picker.search,
    body: h('div.stack.relabel', picker.search, scopeFields, picker.list, picker.emptyText, errorText),
    footer: [
      h(
        'span.muted.small.grow',
        draft
          ? 'Arrows choose, Enter takes, Escape discards the box.'
          : 'Arrows choose, Enter takes, Ctrl+Enter takes and accepts the track, Alt+B switches between track and box.',
      ),
      ...(draft ? [notInSetButton] : [resetButton, notInSetButton]),
      h('button.btn', { onclick: close }, 'Cancel'),
    ],
    update(state) {
      if (state.labels !== labels) offerLabels();
    },
  };
}
