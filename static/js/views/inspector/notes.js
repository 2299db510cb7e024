// @ts-check
/** Notes pinned to frames of the track. */

import { trackName } from '../../model/track_name.js';
import { seek } from '../../store/actions/review.js';
import { editTrack } from '../edit_track.js';
import { fill, h, reconcile, setText } from '../dom.js';
import { moment } from '../../model/format.js';
import { icon, iconButton } from '../icons.js';
import { randomId } from '../../core/random_id.js';

/** @param {import('../../page-types.js').ViewApp} app @param {AbortSignal} signal */
export function createNotes(app, signal) {
  const list = h('ul.notes');
  const text = h('textarea.textarea', { rows: '2', maxlength: '2000', 'aria-label': 'Note on the current frame' });
  const add = h('button.btn.btn-small', { type: 'submit' }, icon('note'), h('span'));
  const form = h('form.notes-form', text, add);
  /** Run and track of the section. */
  let run = '';
  let key = '';
  /** Ends the current edit of a note. */
  let finishEdit = () => {};
  form.addEventListener('submit', (event) => {
    event.preventDefault();
    const content = text.value.trim();
    if (content === '' || !editTrack(app, key, { name: 'add_note', note_id: randomId(), text: content }, run)) return;
    text.value = '';
    app.notes.set(run, key, '');
  });
  text.addEventListener('input', () => app.notes.set(run, key, text.value));
  // the dialog for notes (P) edits the same draft
  app.notes.onChange(() => document.activeElement === text || showDraft(), signal);

  function showDraft() {
    const draft = app.notes.get(run, key);
    if (text.value !== draft) text.value = draft;
  }
  // Letters are commands of the review screen, but text here.
  form.addEventListener('keydown', (event) => {
    event.stopPropagation();
    if (event.key === 'Enter' && (event.ctrlKey || event.metaKey)) form.requestSubmit();
  });

  /** @param {HTMLElement} item @param {import('../../types.js').Note} note */
  function show(item, note) {
    if (item.dataset.text === note.text) return;
    item.dataset.text = note.text;
    fill(
      item,
      h(
        'div.row',
        h('button.btn-link.small', { onclick: () => app.store.dispatch(seek, note.frame) }, `frame ${note.frame}`),
        h('span.small.muted.truncate.grow', `${note.author}, ${moment(note.time)}`),
        iconButton('label', 'Edit the note', () => editNote(item, note)),
        iconButton('delete', 'Remove the note', () => editTrack(app, key, { name: 'remove_note', note_id: note.id })),
      ),
      h('p.note-text', note.text),
    );
  }

  /** @param {HTMLElement} item @param {import('../../types.js').Note} note */
  function editNote(item, note) {
    const target = { run, key };
    const field = h('textarea.textarea', { rows: '2', 'aria-label': 'Text of the note', value: note.text });
    const saveNote = () => {
      const content = field.value.trim();
      item.dataset.text = '';
      show(item, note);
      if (content !== '' && content !== note.text)
        editTrack(app, target.key, { name: 'edit_note', note_id: note.id, text: content }, target.run);
      finishEdit = () => {};
    };
    finishEdit = () => field.blur();
    field.addEventListener('keydown', (event) => {
      event.stopPropagation();
      if (event.key === 'Escape') field.value = note.text;
      if (event.key === 'Escape' || (event.key === 'Enter' && !event.shiftKey)) {
        event.preventDefault();
        field.blur();
      }
    });
    field.addEventListener('blur', saveNote, { once: true });
    fill(item, field);
    field.focus();
  }

  return {
    element: h('div.inspector-section', h('h3', 'Notes'), list, form),
    /** @param {import('./index.js').Inspected} inspected */
    update({ entry, doc, review }) {
      const runId = review.run?.id ?? '';
      const isOtherTrack = runId !== run || entry.key !== key;
      if (isOtherTrack) finishEdit();
      run = runId;
      key = entry.key;
      if (isOtherTrack) showDraft();
      reconcile(
        list,
        doc?.notes ?? [],
        (note) => note.id,
        () => h('li.note'),
        show,
      );
      setText(add.children[1], `Pin to track ${trackName(key, doc ?? undefined)}, frame ${review.frame}`);
    },
  };
}
