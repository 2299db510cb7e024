// @ts-check
/** Choose a label by typing part of its name, its code or its number, or add a label. Works by keyboard alone. */

import { sentence } from '../../api/errors.js';
import { NO_CLASS } from '../../model/documents.js';
import { labelAt, labelOf } from '../../model/effective.js';
import { labelFinder } from '../../model/label_finder.js';
import { labelName, offeredLabels, resolveLabelId } from '../../model/labels.js';
import { documentLane, lastVotes } from '../../model/track_lane.js';
import { trackName } from '../../model/track_name.js';
import { createTrack as createTrack } from '../../operations/place_box.js';
import { followDrawn } from '../../operations/follow.js';
import { labelSetKey } from '../../editing/label_sets.js';
import { judge } from '../../operations/verdicts.js';
import { docOf } from '../../editing/revisions.js';
import { shownTrack } from '../../review/shown_tracks.js';
import { edit } from '../app.js';
import { h, setText } from '../dom.js';
import { percent } from '../../model/format.js';
import { recall, remember } from '../../core/preferences.js';
import { labelOfKey, noteRecent, recentLabels } from '../recent_labels.js';
import { createLabelChoice } from './label-choice.js';

/** @typedef {import('../../types.js').Label} Label */

/**
 * The labels in their order before any typing: some come first, the rest keep their order.
 *
 * @param {readonly Label[]} labels
 * @param {readonly (number|null|undefined)[]} first   their ids; unknown ids are ignored
 * @returns {Label[]}
 */
export function withFirst(labels, first) {
  return [...new Set([...first.flatMap((id) => labels.find((label) => label.id === id) ?? []), ...labels])];
}

/**
 * The engine's leading classes of a track with their shares of the votes, largest first.
 *
 * @param {Pick<import('../../types.js').TrackLane, 'classes'|'votes'>|null|undefined} lane   null: not loaded, or the engine has none
 * @returns {Map<number, number>} class -> share; small shares too, because the true class of a confidently misread sign has a small share
 */
export function votesFor(lane) {
  const shares = (lane && lastVotes(lane)) ?? [];
  const read = shares.map((share, i) => /** @type {[number, number]} */ ([Number(lane?.classes[i]), share]));
  return new Map(read.filter(([, share]) => share > 0).sort(([, a], [, b]) => b - a));
}

/**
 * Whether people have already set this label, so that there is nothing to store.
 *
 * @param {import('../../types.js').TrackDoc} doc
 * @param {number|null} frame       frame of a single box; null: the whole track
 * @param {number|null} class_id
 */
export function isSaid(doc, frame, class_id) {
  if (frame !== null) return (doc.keys[frame]?.class_id ?? null) === class_id;
  return doc.class_id === class_id && Object.values(doc.keys).every((key) => key.class_id === null);
}

/**
 * The side of the screen on which the dialog does not cover the sign.
 *
 * @param {import('../../state-types.js').ReviewState|null} review
 * @param {import('../../types.js').Box|null} box
 * @returns {'left'|'right'|undefined}
 */
export function sideOf(review, box) {
  if (!review || !box) return undefined;
  return (box[0] + box[2]) / 2 < review.viewport.x ? 'right' : 'left';
}

/**
 * The last row of the list, for a text that names none of the labels on offer.
 *
 * @param {readonly Label[]} labels   the whole set
 * @param {string} text
 * @returns {{text: string, hidden: Label|null}|null} hidden: the label that it names, if that is only hidden
 */
export function furtherRow(labels, text) {
  if (text === '' || text.startsWith('#')) return null;
  const named = labelFinder(labels).find(text);
  if (named === null || named.how === 'number') return { text: `Add '${text}'`, hidden: null };
  return named.label.hidden ? { text: `'${named.label.name}' is hidden: show it again and use it`, hidden: named.label } : null;
}

/**
 * @param {import('./layer.js').Setup<'relabel'>} setup
 * @returns {import('./layer.js').Content}
 */
export function relabelDialog({ app, data, close, signal }) {
  const { review } = app.store.get();
  /** @type {import('../../state-types.js').Draft|null} */
  const draft = data.draft ?? null;
  /** @type {string|null} */
  const key = draft ? null : (data.key ?? review?.selected ?? null);
  const frame = draft?.frame ?? data.frame ?? review?.frame ?? 0;
  const doc = review && key ? docOf(review, key) : null;
  /** @param {number} id */
  const engineClass = (id) => review?.tracks?.class_id[review.tracks.id.indexOf(id)] ?? null;
  const votes = votesFor(review && key ? documentLane(key, review.docs[key], review.laneOf)?.lane : null);
  let { labels } = app.store.get();
  let set = labelSetKey(app.store.get());
  /** Whether the track is accepted together with the label. */
  let accepting = false;
  const box = h('input', { type: 'radio', name: 'scope', id: 'scope-box', checked: data.scope === 'box', onchange: () => tellBack() });
  const track = h('input', { type: 'radio', name: 'scope', id: 'scope-track', checked: data.scope !== 'box', onchange: () => tellBack() });
  const scopes = h(
    'fieldset.row.scopes',
    { hidden: draft !== null },
    h('legend.visually-hidden', 'What gets the label'),
    h('label.row', track, 'Whole track'),
    h('label.row', box, `Only the box at frame ${frame}`),
  );
  const error = h('p.field-error', { role: 'alert' });
  const choice = createLabelChoice({
    take: choose,
    placeholder: 'Type a name, a code or a number',
    aside: ({ id }) => ((votes.get(id) ?? 0) >= 0.005 ? percent(votes.get(id)) : ''),
    last: (text) => {
      const row = furtherRow(labels, text);
      return (
        row && { text: row.text, run: () => void change(row.hidden ? { type: 'show', id: row.hidden.id } : { type: 'add', name: text }) }
      );
    },
  });

  /** Offer the labels again after a change of the set. */
  function offer() {
    labels = app.store.get().labels;
    set = labelSetKey(app.store.get());
    const ids = draft
      ? [labelOfKey(labels, recall('draw.label')), ...recentLabels(labels)]
      : [
          resolveLabelId(labels, doc && labelAt(doc, frame, engineClass)),
          ...[...votes.keys()].map((id) => resolveLabelId(labels, id)),
          ...recentLabels(labels),
        ];
    const some = withFirst(offeredLabels(labels), ids);
    // put the track's present label first; for none of the labels nothing is marked, because Enter would take it
    choice.offer(
      labels,
      some,
      Math.max(
        draft ? 0 : -1,
        some.findIndex(({ id }) => id === ids[0]),
      ),
    );
    tellBack();
  }

  /** Change the set, then assign the changed label. @param {import('../../types.js').LabelChange} wanted */
  async function change(wanted) {
    choice.search.readOnly = true;
    setText(error, '');
    try {
      const { label } = await app.labels.change(wanted, set);
      if (signal.aborted) return;
      if (label !== null) choose(label);
    } catch (thrown) {
      if (signal.aborted) return;
      setText(error, sentence(thrown));
      offer();
    } finally {
      choice.search.readOnly = false;
    }
  }

  /** @param {Label} label */
  function choose(label) {
    noteRecent(label);
    if (draft) remember('draw.label', label.key);
    put(label.id, label.key);
  }

  /** @param {number|null} class_id @param {string} [label_key]   key of the chosen label, because the set may change */
  function put(class_id, label_key) {
    const now = app.store.get().review;
    const said = now && key ? docOf(now, key) : null;
    if (draft) {
      createTrack(app, draft, class_id, label_key);
      followDrawn(app, draft);
    } else if (key && !(said && isSaid(said, box.checked ? frame : null, class_id)))
      edit(app, key, {
        name: box.checked ? 'relabel_box' : 'relabel_track',
        class_id,
        frame,
        ...(label_key !== undefined && { label_key }),
      });
    close();
    if (accepting && key && app.store.get().review?.selected === key) judge(app, 'accepted');
  }

  /** The button that removes a label: a box then has its track's label, a track the engine's. */
  function tellBack() {
    const [text, id] = box.checked
      ? ['As the whole track', doc && labelOf(doc, engineClass)]
      : ['As read by the engine', doc && labelOf({ ...doc, class_id: null }, engineClass)];
    setText(back, text);
    back.title = `${text}: ${labelName(labels, id)}`;
    back.hidden = !box.checked && !doc?.key.startsWith('m') && !doc?.segments.length;
  }

  // in the capture phase, before the list takes the label
  choice.search.addEventListener(
    'keydown',
    (event) => {
      accepting = event.key === 'Enter' && (event.ctrlKey || event.metaKey) && draft === null;
    },
    { capture: true },
  );
  choice.search.addEventListener('keydown', (event) => {
    if (event.altKey && event.key.toLowerCase() === 'b') {
      event.preventDefault();
      (box.checked ? track : box).checked = true;
      tellBack();
    }
  });
  if (!draft) choice.onEnter(close);
  const unknown = h('button.btn', { title: 'A sign that no label of the set names', onclick: () => put(NO_CLASS) }, 'Not in the set');
  const back = h('button.btn', { onclick: () => put(null) });
  offer();
  choice.reveal();
  return {
    side: sideOf(review, draft?.box ?? (review && key ? shownTrack(review, key)?.box : null) ?? null),
    title: key ? `Relabel track ${trackName(key, review?.docs[key])}` : 'Label of the new track',
    size: 'middle',
    focus: choice.search,
    body: h('div.stack.relabel', choice.search, scopes, choice.list, choice.none, error),
    footer: [
      h(
        'span.muted.small.grow',
        draft
          ? 'Arrows choose, Enter takes, Escape discards the box.'
          : 'Arrows choose, Enter takes, Ctrl+Enter takes and accepts the track, Alt+B switches between track and box.',
      ),
      ...(draft ? [unknown] : [back, unknown]),
      h('button.btn', { onclick: close }, 'Cancel'),
    ],
    update(state) {
      if (state.labels !== labels) offer();
    },
  };
}
