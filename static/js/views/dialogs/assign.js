// @ts-check
/** Assign a video, or some of its frames, to a person, and change or remove assignments. */

import { sentence } from '../../api/errors.js';
import { assignedFrames, STATES } from '../../model/team.js';
import { dropAssignment, putAssignment } from '../../store/actions/team.js';
import { fill, h, setText } from '../dom.js';
import { icon } from '../icons.js';
import { toast } from '../../core/toast.js';
import { field, numberInput } from './fields.js';

/**
 * @param {import('./layer.js').Setup<'assign'>} setup
 * @returns {import('./layer.js').Content}
 */
export function assignDialog({ app, data, close, signal }) {
  const { store, api } = app;
  const video = store.get().videos?.find(({ id }) => id === data.video);
  const person = h('select.select', { id: 'assign-person' });
  const first = numberInput('assign-first', '0', () => setText(problem, ''));
  const last = numberInput('assign-last', video?.frames ? String(video.frames - 1) : '', () => setText(problem, ''));
  const comment = h('textarea.textarea', { id: 'assign-comment', rows: '2', maxlength: 2000 });
  const problem = h('p.field-error', { role: 'alert' });
  const given = h('ul.assigned-list', { 'aria-label': 'Assignments of this video' });
  /** @type {readonly import('../../types.js').Assignment[]|null} */ let shown = null;

  api.people({ signal }).then(
    (people) => {
      const workers = people.filter(({ role }) => role !== 'viewer');
      fill(
        person,
        ...workers.map(({ name, role, assignments }) =>
          h('option', { value: name }, `${name} (${role}${assignments ? `, ${assignments} open` : ''})`),
        ),
      );
    },
    (thrown) => {
      if (!signal.aborted) setText(problem, sentence(thrown));
    },
  );

  /** @param {import('../../types.js').Assignment} one */
  async function takeBack(one) {
    try {
      await api.removeAssignment(one.id, { signal });
      store.dispatch(dropAssignment, one.id);
    } catch (thrown) {
      if (!signal.aborted) setText(problem, sentence(thrown));
    }
  }

  /** @param {import('../../types.js').Assignment} one */
  const row = (one) =>
    h(
      'li.row',
      h('span', { class: `state-chip state-${one.state}` }, STATES[one.state]),
      h('span.grow.truncate', `${one.person}, ${assignedFrames(one)}`),
      h(
        'button.btn.btn-quiet.btn-small.btn-icon',
        {
          title: 'Remove this assignment',
          'aria-label': `Remove the assignment of ${one.person}`,
          onclick: () => void takeBack(one),
        },
        icon('trash'),
      ),
    );

  async function submit() {
    const [from, to] = [Number(first.value), Number(last.value)];
    const frames = video?.frames ?? null;
    if (!Number.isInteger(from) || !Number.isInteger(to) || first.value.trim() === '' || last.value.trim() === '')
      return setText(problem, 'First and last frame must be whole numbers.');
    try {
      const made = await api.assign(
        {
          videos: [data.video],
          person: person.value,
          first: from,
          stop: frames !== null && to === frames - 1 ? null : to + 1,
          comment: comment.value.trim(),
        },
        { signal },
      );
      store.dispatch((state) => made.reduce(putAssignment, state));
      toast(`${video?.name ?? 'The video'} is assigned to ${person.value}.`, { tone: 'good' });
      close();
    } catch (thrown) {
      if (!signal.aborted) setText(problem, sentence(thrown));
    }
  }

  return {
    title: `Assign ${video?.name ?? 'the video'}`,
    size: 'narrow',
    focus: person,
    submit: () => void submit(),
    body: h(
      'div.stack',
      given,
      field('To', person),
      h('div.row', field('First frame', first), field('Last frame', last)),
      field('Instructions', comment, 'Shown above the picture. May be empty.'),
      problem,
    ),
    footer: [h('span.grow'), h('button.btn', { onclick: close }, 'Cancel'), h('button.btn.btn-primary', { type: 'submit' }, 'Assign')],
    update(state) {
      if (state.assignments === shown) return;
      shown = state.assignments;
      const mine = shown.filter(({ video_id }) => video_id === data.video);
      given.hidden = mine.length === 0;
      fill(given, ...mine.map(row));
    },
  };
}
