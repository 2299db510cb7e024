// @ts-check
/** Label, probability, runner-up and review state of the selected track. */

import { edit } from '../app.js';
import { h, setAttribute, setText } from '../dom.js';
import { count, percent } from '../format.js';
import { icon } from '../icons.js';

/** @typedef {import('../../types.js').TrackDoc['review']} Review */
/** @type {{review: Review, label: string, icon: import('../icons.js').IconName, key: string}[]} */
const CHOICES = [
  { review: 'accepted', label: 'Accept', icon: 'accept', key: 'A' },
  { review: 'rejected', label: 'Reject', icon: 'reject', key: 'X' },
  { review: 'needs_work', label: 'Needs work', icon: 'needs_work', key: 'W' },
];

/** @param {import('../app.js').ViewApp} app @param {AbortSignal} signal */
export function createHead(app, signal) {
  const picture = h('img', { class: 'inspector-picture', alt: '' });
  const name = h('h2', { class: 'inspector-name' });
  const sub = h('p', { class: 'small muted' });
  const human = h('p', { class: 'small inspector-human' });
  const own = h('span', { class: 'inspector-own' });
  const other = h('span', { class: 'inspector-other' });
  const margin = h('div', { class: 'inspector-margin', role: 'img' }, own, other);
  const votes = h('p', { class: 'small inspector-votes' });
  /** @type {Review} */ let now = 'open';
  let key = '';
  const buttons = CHOICES.map((choice) => {
    const button = h('button', { class: 'btn btn-small', type: 'button', title: `${choice.label} (${choice.key})` }, icon(choice.icon), choice.label);
    button.addEventListener('click', () => edit(app, key, { name: 'set_review', review: now === choice.review ? 'open' : choice.review }), { signal });
    return button;
  });
  return {
    element: h('div', { class: 'inspector-head' }, h('div', { class: 'inspector-title' }, picture, h('div', { class: 'grow' }, name, sub, human)),
      margin, votes, h('div', { class: 'inspector-review', role: 'group', 'aria-label': 'Review state' }, buttons)),
    /** @param {import('./index.js').Inspected} inspected */
    update({ state, review, entry }) {
      /** @param {number|null|undefined} id */
      const nameOf = (id) => state.labels.find((label) => label.id === id)?.name ?? (id === null || id === undefined ? 'no class' : `class ${id}`);
      key = entry.key;
      now = entry.review;
      const label = state.labels.find((one) => one.id === entry.class_id);
      picture.hidden = label === undefined;
      if (label && picture.getAttribute('src') !== label.picture) picture.src = label.picture;
      setText(name, entry.not_a_sign ? 'Not a sign' : nameOf(entry.class_id));
      const frames = entry.last - entry.first + 1;
      setText(sub, `Track ${entry.name} · frames ${count(entry.first)}–${count(entry.last)} (${count(frames)})`);
      const i = entry.column;
      const tracks = review.tracks;
      const share = tracks && i >= 0 ? tracks.share[i] : null;
      const second = tracks && i >= 0 ? tracks.runner_up_share[i] : null;
      human.hidden = !entry.relabelled && entry.track !== null;
      setText(human, entry.relabelled && tracks && i >= 0 ? `Label set by a person; the engine says ${nameOf(tracks.class_id[i])}.` : entry.relabelled ? 'Label set by a person.' : 'Made by a person.');
      margin.hidden = votes.hidden = share === null;
      own.style.setProperty('width', `${(share ?? 0) * 100}%`);
      other.style.setProperty('width', `${(second ?? 0) * 100}%`);
      const runner = tracks && i >= 0 && tracks.runner_up[i] !== null ? `; runner-up ${nameOf(tracks.runner_up[i])} ${percent(second)}, margin ${percent((share ?? 0) - (second ?? 0))}` : '';
      const engines = entry.relabelled && tracks && i >= 0 ? `The engine’s ${nameOf(tracks.class_id[i])}: fused probability` : 'Fused probability';
      setText(votes, `${engines} ${percent(share)}${runner}`);
      setAttribute(margin, 'aria-label', votes.textContent);
      buttons.forEach((button, k) => setAttribute(button, 'aria-pressed', String(CHOICES[k].review === entry.review)));
    },
  };
}
