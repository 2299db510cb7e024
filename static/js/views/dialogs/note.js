// @ts-check
/** A note on a track, pinned to a frame. */

import { trackName } from '../../model/track_name.js';
import { editTrack } from '../edit_track.js';
import { h, setText } from '../dom.js';
import { randomId } from '../../core/random_id.js';

const MAX_LENGTH = 2000;

/** @type {import('./index.js').CreateDialog<'note'>} */
export function noteDialog({ app, data, close }) {
  const review = app.store.get().review;
  const key = data.key ?? review?.selected ?? null;
  const frame = data.frame ?? review?.frame ?? 0;
  const run = review?.run?.id ?? '';
  // a new note starts with the draft from the inspector, if any
  const isDraft = key !== null && !data.note_id;
  const textInput = h('textarea.textarea', {
    rows: 4,
    maxlength: MAX_LENGTH,
    id: 'note-text',
    value: data.text ?? (isDraft ? app.notes.get(run, key) : ''),
    'aria-describedby': 'note-hint note-error',
  });
  const errorText = h('p.field-error', { id: 'note-error', role: 'alert', hidden: true });
  /** @param {string} value */
  const keepDraft = (value) => {
    if (isDraft) app.notes.set(run, key, value);
  };
  textInput.addEventListener('input', () => keepDraft(textInput.value));
  textInput.addEventListener('keydown', (event) => {
    if (event.key === 'Enter' && (event.ctrlKey || event.metaKey)) submit();
  });

  function submit() {
    const value = textInput.value.trim();
    if (!value || !key) {
      errorText.hidden = false;
      setText(errorText, key ? 'Write something first, or close the dialog.' : 'Select a track first: a note belongs to a track.');
      textInput.focus();
      return;
    }
    if (
      editTrack(
        app,
        key,
        data.note_id
          ? { name: 'edit_note', note_id: data.note_id, text: value, frame }
          : { name: 'add_note', note_id: randomId(), text: value, frame },
      )
    )
      keepDraft('');
    close();
  }

  return {
    title: data.note_id ? 'Change the note' : key ? `Note on track ${trackName(key, review?.docs[key])}, frame ${frame}` : 'Note',
    size: 'narrow',
    focus: textInput,
    submit,
    body: h(
      'div.field',
      h('label.field-label', { for: 'note-text' }, 'Text'),
      textInput,
      h('span.field-hint', { id: 'note-hint' }, isDraft ? 'Ctrl+Enter saves; Escape keeps the text as a draft.' : 'Ctrl+Enter saves.'),
      errorText,
    ),
    footer: [
      h(
        'button.btn',
        {
          onclick: () => {
            keepDraft('');
            close();
          },
        },
        'Cancel',
      ),
      h('button.btn.btn-primary', { type: 'submit' }, 'Save'),
    ],
  };
}
