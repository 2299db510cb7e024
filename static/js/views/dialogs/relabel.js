// @ts-check
/** Choose one of the classes by typing part of its name or its number; keyboard alone is enough. */

import {edit} from '../app.js';
import {h, reconcile, setText} from '../dom.js';

/** @typedef {import('../../types.js').Label} Label */

/**
 * The classes that a text finds, best first: the number itself, names that begin with it, words that begin with its
 * words, then names that contain them.
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
    if (String(label.id) === wanted) return 0;
    if (name.startsWith(wanted)) return 1;
    if (words.every((word) => name.split(/[\s/()-]+/).some((part) => part.startsWith(word)))) return 2;
    if (words.every((word) => name.includes(word))) return 3;
    return 4;
  };
  return labels.map((label) => ({label, rank: rank(label)})).filter((found) => found.rank < 4)
    .sort((a, b) => a.rank - b.rank || a.label.id - b.label.id).map((found) => found.label);
}

/**
 * @param {import('./layer.js').Setup} setup
 * @returns {import('./layer.js').Content}
 */
export function relabelDialog({app, data, close}) {
  const {labels, review} = app.store.get();
  const key = data.key ?? review?.selected ?? null;
  const frame = data.frame ?? review?.frame ?? 0;
  let found = [...labels];
  let at = 0;
  const list = h('ul', {class: 'labels', role: 'listbox', id: 'labels', 'aria-label': 'Classes'});
  const search = h('input', {
    class: 'input', type: 'text', role: 'combobox', autocomplete: 'off', spellcheck: 'false', placeholder: 'Type a name or a number',
    'aria-label': 'Class', 'aria-expanded': 'true', 'aria-controls': 'labels', 'aria-autocomplete': 'list', oninput: () => {
      at = 0;
      show();
    },
  });
  const box = h('input', {type: 'radio', name: 'scope', id: 'scope-box', checked: data.scope === 'box'});
  const track = h('input', {type: 'radio', name: 'scope', id: 'scope-track', checked: data.scope !== 'box'});
  const scopes = h('fieldset', {class: 'row scopes', hidden: Boolean(data.onChoose)},
    h('legend', {class: 'visually-hidden'}, 'What gets the class'),
    h('label', {class: 'row'}, track, 'Whole track'),
    h('label', {class: 'row'}, box, `Only the box at frame ${frame}`));
  const none = h('p', {class: 'muted labels-none', role: 'status'});

  /** @param {Label} label */
  function create(label) {
    return h('li', {class: 'label', role: 'option', id: `label-${label.id}`, onclick: () => choose(label)},
      h('img', {class: 'label-picture', src: label.picture, alt: '', width: 32, height: 32}),
      h('span', {class: 'label-id muted small'}, label.id), h('span', {class: 'truncate'}, label.name));
  }

  function show() {
    found = findLabels(labels, search.value);
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
    if (data.onChoose) data.onChoose(label.id);
    else if (key) edit(app, key, {name: box.checked ? 'relabel_box' : 'relabel_track', class_id: label.id, frame});
    close();
  }

  search.addEventListener('keydown', (event) => {
    const columns = 2;
    const steps = /** @type {Record<string, number>} */ ({ArrowDown: columns, ArrowUp: -columns, PageDown: 10, PageUp: -10});
    // Left and right move in the list only where they would not move in the text.
    if (!search.value) Object.assign(steps, {ArrowRight: 1, ArrowLeft: -1});
    const step = steps[event.key];
    if (step !== undefined) {
      event.preventDefault();
      at = Math.max(0, Math.min(found.length - 1, at + step));
      show();
    } else if (event.key === 'Enter') {
      event.preventDefault();
      choose(found[at]);
    } else if (event.altKey && event.key.toLowerCase() === 'b') {
      event.preventDefault();
      (box.checked ? track : box).checked = true;
    }
  });
  show();
  const current = labels.findIndex(({id}) => id === data.current);
  if (current >= 0) {
    at = current;
    show();
  }
  return {
    title: data.onChoose ? 'Class of the new track' : `Relabel track ${key ?? ''}`, size: 'middle', focus: search,
    body: h('div', {class: 'stack relabel'}, search, scopes, list, none),
    footer: [h('span', {class: 'muted small grow'}, 'Arrows choose, Enter takes, Alt+B switches between track and box.'), h('button', {class: 'btn', type: 'button', onclick: close}, 'Cancel')],
  };
}
