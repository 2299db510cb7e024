// @ts-check
/** Assign a video, or some of its frames, to a person, and change or remove assignments. */

import { errorMessage } from '../../api/errors.js';
import { parseFrames } from '../../model/exchange.js';
import { assignedFrames, STATES } from '../../model/team.js';
import { dropAssignment, putAssignment } from '../../store/actions/team.js';
import { fill, h, setText } from '../dom.js';
import { iconButton } from '../icons.js';
import { toast } from '../../core/toast.js';
import { field, numberInput } from './fields.js';

/** @type {import('./index.js').CreateDialog<'assign'>} */
export function assignDialog({ app, data, close, signal }) {
  const { store, api } = app;
  const video = store.get().videos?.find(({ id }) => id === data.video);
  const personSelect = h('select.select', { id: 'assign-person' });
  const firstInput = numberInput('assign-first', '0', () => setText(errorText, ''));
  const lastInput = numberInput('assign-last', video?.frames ? String(video.frames - 1) : '', () => setText(errorText, ''));
  const comment = h('textarea.textarea', { id: 'assign-comment', rows: '2', maxlength: 2000 });
  const errorText = h('p.field-error', { role: 'alert' });
  const assignmentList = h('ul.assigned-list', { 'aria-label': 'Assignments of this video' });
  /** @type {readonly import('../../types.js').Assignment[]|null} */ let shownAssignments = null;

  api.people({ signal }).then(
    (people) => {
      const workers = people.filter(({ role }) => role !== 'viewer');
      fill(
        personSelect,
        ...workers.map(({ name, role, assignments }) =>
          h('option', { value: name }, `${name} (${role}${assignments ? `, ${assignments} open` : ''})`),
        ),
      );
    },
    (thrown) => {
      if (!signal.aborted) setText(errorText, errorMessage(thrown));
    },
  );

  /** @param {import('../../types.js').Assignment} assignment */
  async function removeAssignment(assignment) {
    try {
      await api.removeAssignment(assignment.id, { signal });
      store.dispatch(dropAssignment, assignment.id);
    } catch (thrown) {
      if (!signal.aborted) setText(errorText, errorMessage(thrown));
    }
  }

  /** @param {import('../../types.js').Assignment} assignment */
  const row = (assignment) =>
    h(
      'li.row',
      h('span', { class: `state-chip state-${assignment.state}` }, STATES[assignment.state]),
      h('span.grow.truncate', `${assignment.person}, ${assignedFrames(assignment)}`),
      iconButton(
        'delete',
        `Remove the assignment of ${assignment.person}`,
        () => void removeAssignment(assignment),
        'Remove this assignment',
      ),
    );

  async function submit() {
    const frames = video?.frames ?? null;
    const range = parseFrames(firstInput.value, lastInput.value, { low: 0, high: frames === null ? 2 ** 31 - 2 : frames - 1 });
    if ('error' in range) return setText(errorText, range.error);
    try {
      const created = await api.assign(
        {
          videos: [data.video],
          person: personSelect.value,
          first: range.first,
          stop: range.stop === frames ? null : range.stop,
          comment: comment.value.trim(),
        },
        { signal },
      );
      store.dispatch((state) => created.reduce(putAssignment, state));
      toast(`${video?.name ?? 'The video'} is assigned to ${personSelect.value}.`, { tone: 'good' });
      close();
    } catch (thrown) {
      if (!signal.aborted) setText(errorText, errorMessage(thrown));
    }
  }

  return {
    title: `Assign ${video?.name ?? 'the video'}`,
    size: 'narrow',
    focus: personSelect,
    submit: () => void submit(),
    body: h(
      'div.stack',
      assignmentList,
      field('To', personSelect),
      h('div.row', field('First frame', firstInput), field('Last frame', lastInput)),
      field('Instructions', comment, 'Shown above the picture. May be empty.'),
      errorText,
    ),
    footer: [h('span.grow'), h('button.btn', { onclick: close }, 'Cancel'), h('button.btn.btn-primary', { type: 'submit' }, 'Assign')],
    update(state) {
      if (state.assignments === shownAssignments) return;
      shownAssignments = state.assignments;
      const videoAssignments = shownAssignments.filter(({ video_id }) => video_id === data.video);
      assignmentList.hidden = videoAssignments.length === 0;
      fill(assignmentList, ...videoAssignments.map(row));
    },
  };
}
