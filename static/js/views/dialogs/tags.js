// @ts-check
/** Add and remove tags of videos. */

import { errorMessage } from '../../api/errors.js';
import { h, setText } from '../dom.js';
import { plural } from '../../model/format.js';
import { toast } from '../../core/toast.js';
import { choiceInput, field, group, textInput } from './fields.js';

/** @type {import('./index.js').CreateDialog<'tags'>} */
export function tagsDialog({ app, data, close, signal }) {
  const usedTags = [...new Set((app.store.get().videos ?? []).flatMap(({ tags }) => tags ?? []))].sort();
  const addInput = textInput('tags-add', { maxlength: 400, placeholder: 'night, rain', list: 'tags-used' });
  const removeInputs = data.known.map((tag) => choiceInput('checkbox', { value: tag }, tag));
  const errorText = h('p.field-error.grow', { role: 'alert' });
  const submitButton = h('button.btn.btn-primary', { type: 'submit' }, 'Save');

  async function submit() {
    const added = addInput.value
      .split(',')
      .map((tag) => tag.trim())
      .filter(Boolean);
    const removed = removeInputs.filter(({ input }) => input.checked).map(({ input }) => input.value);
    if (added.length + removed.length === 0) {
      setText(errorText, 'Write a tag, or select one to remove.');
      return;
    }
    submitButton.disabled = true;
    try {
      const { changed } = await app.api.tagVideos({ videos: data.videos, add: added, remove: removed }, { signal });
      toast(`${plural(changed, 'video')} changed.`, { tone: 'good' });
      close();
      data.done();
    } catch (thrown) {
      if (!signal.aborted) setText(errorText, errorMessage(thrown));
    } finally {
      submitButton.disabled = false;
    }
  }

  return {
    title: `Tags of ${plural(data.videos.length, 'video')}`,
    size: 'narrow',
    focus: addInput,
    submit: () => void submit(),
    body: h(
      'div.stack',
      field('Add', addInput, 'Separate several with commas.'),
      h(
        'datalist',
        { id: 'tags-used' },
        usedTags.map((tag) => h('option', { value: tag })),
      ),
      removeInputs.length > 0 && group('Remove', h('div.ticks', ...removeInputs.map(({ element }) => element))),
    ),
    footer: [errorText, h('button.btn', { onclick: close }, 'Cancel'), submitButton],
  };
}
