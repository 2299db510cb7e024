// @ts-check
/**
 * Merge a label into another one: its tracks then count as the other label, until the merge is undone in the history.
 */

import { errorMessage } from '../../api/errors.js';
import { offeredLabels } from '../../model/labels.js';
import { h, setText } from '../dom.js';
import { plural } from '../../model/format.js';
import { icon } from '../icons.js';
import { toast } from '../../core/toast.js';
import { createLabelPicker } from './label_picker.js';

/** @typedef {import('../../types.js').Label} Label */

/**
 * The consequences of a merge, in a sentence or two.
 * @param {Label} label
 * @param {Label} into
 * @param {import('../../types.js').LabelUsage|null} usage   null: not known
 */
export function describeMerge(label, into, usage) {
  const used = usage?.labels[label.id];
  const sentences = [
    used
      ? `${plural(used.tracks, 'track')} in ${plural(used.videos, 'video')} ${used.tracks === 1 ? 'is' : 'are'} '${label.name}' and will count as '${into.name}'.`
      : usage && !usage.unread && `No track is '${label.name}' yet.`,
    usage?.unread && `The tracks of ${plural(usage.unread, 'more video')} are not counted.`,
    `Its names will mean '${into.name}'. The merge can be undone in the history; stored data is not rewritten.`,
  ];
  return sentences.filter(Boolean).join(' ');
}

/** @type {import('./index.js').CreateDialog<'label-merge'>} */
export function labelMergeDialog({ app, data, close, signal }) {
  /** @type {Label} */ const label = data.label;
  /** @type {Label|null} */ let into = null;
  const summary = h('p', { role: 'status' }, `Which label is '${label.name}'?`);
  const errorText = h('p.field-error.grow', { role: 'alert' });
  const submitButton = h('button.btn.btn-primary', { type: 'submit', disabled: true }, icon('merge'), 'Merge');
  const picker = createLabelPicker({
    placeholder: 'Type the name of the label that stays',
    onPick: (chosen) => {
      into = chosen;
      setText(summary, describeMerge(label, chosen, data.usage));
      submitButton.disabled = false;
      submitButton.focus();
    },
  });
  picker.offer(
    data.labels,
    offeredLabels(data.labels).filter(({ id }) => id !== label.id),
    -1,
  );

  async function submit() {
    if (into === null || submitButton.disabled) return;
    submitButton.disabled = true;
    setText(errorText, '');
    try {
      const { sentence: message, version } = await app.labels.change({ type: 'merge', id: label.id, into: into.id }, data.set);
      close();
      toast(message, {
        tone: 'good',
        action: {
          label: 'Undo',
          run: () =>
            void app.labels.change({ type: 'undo', version }, data.set).then(
              (answer) => toast(answer.sentence, { tone: 'good' }),
              (thrown) => toast(errorMessage(thrown), { tone: 'bad' }),
            ),
        },
      });
    } catch (thrown) {
      if (!signal.aborted) setText(errorText, errorMessage(thrown));
      submitButton.disabled = false;
    }
  }

  picker.reveal();
  return {
    title: `Merge '${label.name}' into another label`,
    size: 'middle',
    focus: picker.search,
    submit: () => void submit(),
    body: h('div.stack.relabel', summary, picker.search, picker.list, picker.emptyText),
    footer: [errorText, h('span.grow'), h('button.btn', { onclick: close }, 'Cancel'), submitButton],
  };
}
