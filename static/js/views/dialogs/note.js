// @ts-check
/** A note on a track, pinned to a frame. */

import { trackName } from '../../model/track_name.js';
import { edit } from '../app.js';
import { h, setText } from '../dom.js';

const LONGEST = 2000;

/**
 * @param {import('./layer.js').Setup<'note'>} setup
 * @returns {import('./layer.js').Content}
 */
export function noteDialog({ app, data, close }) {
  const review = app.store.get().review;
  const key = data.key ?? review?.selected ?? null;
  const frame = data.frame ?? review?.frame ?? 0;
  const run = review?.run?.id ?? '';
  // a new note starts with the draft from the inspector, if any
  const draft = key !== null && !data.note_id;
  const text = h('textarea.textarea', {
    rows: 4,
    maxlength: LONGEST,
    id: 'note-text',
    value: data.text ?? (draft ? app.notes.get(run, key) : ''),
    'aria-describedby': 'note-hint note-error',
  });
  const error = h('p.field-error', { id: 'note-error', role: 'alert', hidden: true });
  /** @param {string} value */
  const keep = (value) => {
    if (draft) app.notes.set(run, key, value);
  };
  text.addEventListener('input', () => keep(text.value));
  text.addEventListener('keydown', (event) => {
    if (event.key === 'Enter' && (event.ctrlKey || event.metaKey)) submit();
  });

  function submit() {
    const value = text.value.trim();
    if (!value || !key) {
      error.hidden = false;
      setText(error, key ? 'Write something first, or close the dialog.' : 'Select a track first: a note belongs to a track.');
      text.focus();
      return;
    }
    if (
      edit(
        app,
        key,
        data.note_id
          ? { name: 'edit_note', note_id: data.note_id, text: value, frame }
          : { name: 'add_note', note_id: crypto.randomUUID(), text: value, frame },
      )
    )
      keep('');
    close();
  }

  return {
    title: data.note_id ? 'Change the note' : key ? `Note on track ${trackName(key, review?.docs[key])}, frame ${frame}` : 'Note',
    size: 'narrow',
    focus: text,
    submit,
    body: h(
      'div.field',
      h('label.field-label', { for: 'note-text' }, 'Text'),
      text,
      h('span.field-hint', { id: 'note-hint' }, draft ? 'Ctrl+Enter saves; Escape keeps the text as a draft.' : 'Ctrl+Enter saves.'),
      error,
    ),
    footer: [
      h(
        'button.btn',
        {
          onclick: () => {
            keep('');
            close();
          },
        },
        'Cancel',
      ),
      h('button.btn.btn-primary', { type: 'submit' }, 'Save'),
    ],
  };
}
