// @ts-check
/** Add and remove tags of videos. */

import { sentence } from '../../api/errors.js';
import { h, setText } from '../dom.js';
import { plural } from '../../model/format.js';
import { toast } from '../../core/toast.js';
import { field, group, choiceInput } from './fields.js';

/**
 * @param {import('./index.js').DialogSetup<'tags'>} setup
 * @returns {import('./index.js').DialogContent}
 */
export function tagsDialog({ app, data, close, signal }) {
  const used = [...new Set((app.store.get().videos ?? []).flatMap(({ tags }) => tags ?? []))].sort();
  const add = h('input.input', {
    type: 'text',
    id: 'tags-add',
    maxlength: 400,
    autocomplete: 'off',
    placeholder: 'night, rain',
    list: 'tags-used',
  });
  const remove = data.known.map((/** @type {string} */ tag) => choiceInput('checkbox', { value: tag }, tag));
  const error = h('p.field-error.grow', { role: 'alert' });
  const go = h('button.btn.btn-primary', { type: 'submit' }, 'Save');

  async function submit() {
    const given = add.value
      .split(',')
      .map((tag) => tag.trim())
      .filter(Boolean);
    const taken = remove.filter((/** @type {any} */ one) => one.input.checked).map((/** @type {any} */ one) => one.input.value);
    if (given.length + taken.length === 0) {
      setText(error, 'Write a tag, or select one to remove.');
      return;
    }
    go.disabled = true;
    try {
      const { changed } = await app.api.tagVideos({ videos: data.videos, add: given, remove: taken }, { signal });
      toast(`${plural(changed, 'video')} changed.`, { tone: 'good' });
      close();
      data.done();
    } catch (thrown) {
      if (!signal.aborted) setText(error, sentence(thrown));
    } finally {
      go.disabled = false;
    }
  }

  return {
    title: `Tags of ${plural(data.videos.length, 'video')}`,
    size: 'narrow',
    focus: add,
    submit: () => void submit(),
    body: h(
      'div.stack',
      field('Add', add, 'Separate several with commas.'),
      h(
        'datalist',
        { id: 'tags-used' },
        used.map((tag) => h('option', { value: tag })),
      ),
      remove.length > 0 && group('Remove', h('div.ticks', ...remove.map((/** @type {any} */ one) => one.element))),
    ),
    footer: [error, h('button.btn', { onclick: close }, 'Cancel'), go],
  };
}
