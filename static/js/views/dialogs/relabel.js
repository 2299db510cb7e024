// @ts-check
/** Choose one of the classes by typing part of its name or its number; keyboard alone is enough. */

import {NO_CLASS} from '../../model/documents.js';
import {labelAt, labelOf} from '../../model/effective.js';
import {OTHER_WORDS, className} from '../../model/label_words.js';
import {documentLane, lastVotes} from '../../model/track_lane.js';
import {trackName} from '../../model/track_name.js';
import {create as createTrack} from '../../operations/boxes.js';
import {followDrawn} from '../../operations/follow.js';
import {docOf} from '../../editing/revisions.js';
import {shownTrack} from '../../review/shown_tracks.js';
import {edit} from '../app.js';
import {h, reconcile, setText} from '../dom.js';
import {percent} from '../format.js';
import {recall, remember} from '../preferences.js';

/** @typedef {import('../../types.js').Label} Label */

/**
 * The classes that a text finds, best first: names with that number in them, the class of that number, names
 * that begin with it, words that begin with its words, names that contain them, then other words for it. What is written on a sign goes
 * before the number of its class: who types 30 and Enter means the speed limit, not class 30.
 *
 * @param {readonly Label[]} labels
 * @param {string} text
 * @returns {Label[]}
 */
export function findLabels(labels, text) {
  const wanted = text.trim().toLowerCase();
  if (!wanted) return [...labels];
  const words = wanted.split(/\s+/);
  /** @param {Label} label */
  const rank = (label) => {
    const name = label.name.toLowerCase();
    const parts = name.split(/[\s/()-]+/);
    if (/^\d+$/.test(wanted) && parts.includes(wanted)) return 0;
    if (String(label.id) === wanted) return 1;
    if (name.startsWith(wanted)) return 2;
    if (words.every((word) => parts.some((part) => part.startsWith(word)))) return 3;
    if (words.every((word) => name.includes(word))) return 4;
    const others = [...parts, ...(OTHER_WORDS[label.id] ?? '').split(' ')];
    return words.every((word) => others.some((part) => part.startsWith(word))) ? 5 : 6;
  };
  return labels.map((label) => ({label, rank: rank(label)})).filter((found) => found.rank < 6)
    .sort((a, b) => a.rank - b.rank || a.label.id - b.label.id).map((found) => found.label);
}

/**
 * The classes in the order in which they are offered before anything is typed: some come first, the others as they are.
 *
 * @param {readonly Label[]} labels
 * @param {readonly (number|null|undefined)[]} first   their ids; what is no class is passed over
 * @returns {Label[]}
 */
export function withFirst(labels, first) {
  return [...new Set([...first.flatMap((id) => labels.find((label) => label.id === id) ?? []), ...labels])];
}

/**
 * What the engine has read a track as: the leading classes with their shares of the votes, the largest first.
 *
 * @param {Pick<import('../../types.js').TrackLane, 'classes'|'votes'>|null|undefined} lane   null: not loaded, or the engine has none
 * @returns {Map<number, number>} class -> share, also of little ones: what was misread for sure hardly shows what it is
 */
export function votesFor(lane) {
  const shares = (lane && lastVotes(lane)) ?? [];
  const read = shares.map((share, i) => /** @type {[number, number]} */ ([Number(lane?.classes[i]), share]));
  return new Map(read.filter(([, share]) => share > 0).sort(([, a], [, b]) => b - a));
}

/** The class that a box was last drawn for: signs come in series. @returns {number|null} */
function drawnLast() {
  const kept = recall('draw.class');
  return kept ? Number(kept) : null;
}

/**
 * Whether people have said just this already, so that there is nothing to store.
 *
 * @param {import('../../types.js').TrackDoc} doc
 * @param {number|null} frame       of the one box that it is about; null: the whole track
 * @param {number|null} class_id
 */
export function isSaid(doc, frame, class_id) {
  if (frame !== null) return (doc.keys[frame]?.class_id ?? null) === class_id;
  return doc.class_id === class_id && Object.values(doc.keys).every((key) => key.class_id === null);
}

/**
 * The side on which the dialog does not hide the sign that it asks about.
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
 * @param {import('./layer.js').Setup} setup
 * @returns {import('./layer.js').Content}
 */
export function relabelDialog({app, data, close}) {
  const {labels, review} = app.store.get();
  /** @type {import('../../state-types.js').Draft|null} */
  const draft = data.draft ?? null;
  /** @type {string|null} */
  const key = draft ? null : data.key ?? review?.selected ?? null;
  const frame = draft?.frame ?? data.frame ?? review?.frame ?? 0;
  const doc = review && key ? docOf(review, key) : null;
  /** @param {number} id */
  const engineClass = (id) => review?.tracks?.class_id[review.tracks.id.indexOf(id)] ?? null;
  const current = draft ? drawnLast() : doc && labelAt(doc, frame, engineClass);
  const votes = votesFor(review && key ? documentLane(key, review.docs[key], review.laneOf)?.lane : null);
  const offered = withFirst(labels, draft ? [] : [current, ...votes.keys()]);
  let found = offered;
  // what the track is now; of none of the classes none is offered, for Enter would take it
  const present = Math.max(draft ? 0 : -1, offered.findIndex(({id}) => id === current));
  let untouched = true;
  let at = present;
  const list = h('ul', {class: 'labels', role: 'listbox', id: 'labels', 'aria-label': 'Classes'});
  const search = h('input', {
    class: 'input', type: 'text', role: 'combobox', autocomplete: 'off', spellcheck: 'false', placeholder: 'Type a name or a number',
    'aria-label': 'Class', 'aria-expanded': 'true', 'aria-controls': 'labels', 'aria-autocomplete': 'list', oninput: () => {
      at = search.value.trim() ? 0 : present;
      untouched = false;
      show();
    },
  });
  const box = h('input', {type: 'radio', name: 'scope', id: 'scope-box', checked: data.scope === 'box', onchange: () => tellBack()});
  const track = h('input', {type: 'radio', name: 'scope', id: 'scope-track', checked: data.scope !== 'box', onchange: () => tellBack()});
  const scopes = h('fieldset', {class: 'row scopes', hidden: draft !== null},
    h('legend', {class: 'visually-hidden'}, 'What gets the class'),
    h('label', {class: 'row'}, track, 'Whole track'),
    h('label', {class: 'row'}, box, `Only the box at frame ${frame}`));
  const none = h('p', {class: 'muted labels-none', role: 'status'});

  /** @param {Label} label */
  function create(label) {
    const share = votes.get(label.id);
    return h('li', {class: 'label', role: 'option', id: `label-${label.id}`, onclick: () => choose(label)},
      h('img', {class: 'label-picture', src: label.picture, alt: '', width: 32, height: 32}),
      h('span', {class: 'label-id muted small'}, label.id), h('span', {class: 'truncate grow'}, label.name),
      share !== undefined && share >= 0.005 && h('span', {class: 'muted small', title: 'Share of the engine’s votes for this track'}, percent(share)));
  }

  function show() {
    found = findLabels(offered, search.value);
    reconcile(list, found, ({id}) => String(id), create, (item, label) => item.setAttribute('aria-selected', String(label === found[at])));
    const chosen = found[at];
    if (chosen) search.setAttribute('aria-activedescendant', `label-${chosen.id}`);
    else search.removeAttribute('aria-activedescendant');
    list.querySelector('[aria-selected="true"]')?.scrollIntoView({block: 'nearest'});
    setText(none, labels.length === 0 ? 'The classes are not loaded yet.' : found.length ? '' : 'No class has that name. Try fewer letters.');
  }

  /** @param {Label|undefined} label */
  function choose(label) {
    if (!label) return;
    if (draft) remember('draw.class', String(label.id));
    put(label.id);
  }

  /** @param {number|null} class_id */
  function put(class_id) {
    const now = app.store.get().review;
    const said = now && key ? docOf(now, key) : null;
    if (draft) {
      createTrack(app, draft, class_id);
      followDrawn(app, draft);
    }
    else if (key && !(said && isSaid(said, box.checked ? frame : null, class_id))) edit(app, key, {name: box.checked ? 'relabel_box' : 'relabel_track', class_id, frame});
    close();
  }

  /** What is left to say nothing: of one box that it is as its track, of a track that it is as the engine says. */
  function tellBack() {
    const [text, id] = box.checked ? ['As the whole track', doc && labelOf(doc, engineClass)] : ['As the engine says', doc && labelOf({...doc, class_id: null}, engineClass)];
    setText(back, text);
    back.title = `${text}: ${className(labels, id)}`;
    back.hidden = !box.checked && !doc?.key.startsWith('m') && !doc?.segments.length;
  }

  search.addEventListener('keydown', (event) => {
    const columns = 2;
    const steps = /** @type {Record<string, number>} */ ({ArrowDown: columns, ArrowUp: -columns, PageDown: 10, PageUp: -10});
    // Left and right move in the list only where they would not move in the text.
    if (!search.value) Object.assign(steps, {ArrowRight: 1, ArrowLeft: -1});
    const step = steps[event.key];
    if (step !== undefined) {
      event.preventDefault();
      at = Math.max(0, Math.min(found.length - 1, at < 0 ? 0 : at + step));
      untouched = false;
      show();
    } else if (event.key === 'Enter') {
      event.preventDefault();
      if (untouched && !draft) close();
      else choose(found[at]);
    } else if (event.altKey && event.key.toLowerCase() === 'b') {
      event.preventDefault();
      (box.checked ? track : box).checked = true;
      tellBack();
    }
  });
  // The list has no height yet: the dialog opens after this.
  requestAnimationFrame(() => list.querySelector('[aria-selected="true"]')?.scrollIntoView({block: 'nearest'}));
  const unknown = h('button', {class: 'btn', type: 'button', title: 'A sign that is none of these classes', onclick: () => put(NO_CLASS)}, 'No class');
  const back = h('button', {class: 'btn', type: 'button', onclick: () => put(null)});
  tellBack();
  show();
  return {
    side: sideOf(review, draft?.box ?? (review && key ? shownTrack(review, key)?.box : null) ?? null),
    title: key ? `Relabel track ${trackName(key, review?.docs[key])}` : 'Class of the new track', size: 'middle', focus: search,
    body: h('div', {class: 'stack relabel'}, search, scopes, list, none),
    footer: [h('span', {class: 'muted small grow'}, draft ? 'Arrows choose, Enter takes, Escape takes the box back.' : 'Arrows choose, Enter takes, Alt+B switches between track and box.'), ...(draft ? [unknown] : [back, unknown]), h('button', {class: 'btn', type: 'button', onclick: close}, 'Cancel')],
  };
}
