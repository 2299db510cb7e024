// @ts-check
/** Give one verdict to all tracks that the queue shows. */

import { parseNumber } from '../../model/exchange.js';
import { MAX_TRACKS_PER_OPERATION, tracksToReview, reviewCommands } from '../../model/bulk_review.js';
import { shownQueue } from '../../model/queue.js';
import { h, setText } from '../dom.js';
import { count, plural } from '../../model/format.js';
import { toast } from '../../core/toast.js';
import { choiceInput, field, group, numberInput } from './fields.js';

/** @typedef {import('../../types.js').TrackDoc['review']} Review */

/** @type {[Review, string, string, string][]} verdict, label of the choice, text of the button before the number, text of the notice after it */
const VERDICTS = [
  ['accepted', 'Accept', 'Accept', 'accepted'],
  ['rejected', 'False positive', 'Mark', 'marked as false positives'],
  ['needs_work', 'Needs work', 'Mark', 'marked as needing work'],
  ['open', 'Open again', 'Open', 'opened again'],
];

/** @type {import('./index.js').CreateDialog<'bulk-review'>} */
export function bulkReviewDialog({ app, close }) {
  const { store } = app;
  const choices = VERDICTS.map(([value, label]) =>
    choiceInput('radio', { name: 'judge-verdict', value, checked: value === 'accepted', onchange: show }, label),
  );
  const openOnly = choiceInput('checkbox', { checked: true, onchange: show }, 'Only tracks without a verdict');
  const maxUncertaintyInput = numberInput('judge-uncertainty', '100', show, { inputmode: 'decimal' });
  const shownText = h('p.muted', { role: 'status' });
  const errorText = h('p.field-error.grow', { role: 'alert' });
  const submitButton = h('button.btn.btn-primary', { type: 'submit' });

  const verdict = () => VERDICTS.find(([value]) => choices.some(({ input }) => input.checked && input.value === value)) ?? VERDICTS[0];

  /** @returns {{shown: number, keys: string[], error: string}} */
  function readSelection() {
    const shown = shownQueue(store.get());
    const uncertainty = parseNumber(maxUncertaintyInput.value, { name: 'The uncertainty', low: 0, high: 100, empty: 100 });
    if ('error' in uncertainty) return { shown: shown.length, keys: [], error: uncertainty.error };
    const [value] = verdict();
    // tracks to open again have a verdict
    const criteria = {
      review: value,
      openOnly: openOnly.input.checked && value !== 'open',
      maxUncertainty: (uncertainty.value ?? 100) / 100,
    };
    return { shown: shown.length, keys: tracksToReview(shown, criteria), error: '' };
  }

  function show() {
    const selection = readSelection();
    const [value, , button] = verdict();
    openOnly.element.hidden = value === 'open';
    setText(errorText, selection.error);
    const steps =
      selection.keys.length > MAX_TRACKS_PER_OPERATION ? ` In steps of ${MAX_TRACKS_PER_OPERATION}, which are undone one by one.` : '';
    setText(
      shownText,
      selection.keys.length === 0
        ? `None of the ${plural(selection.shown, 'shown track')} would change.`
        : `${count(selection.keys.length)} of the ${plural(selection.shown, 'shown track')}.${steps}`,
    );
    setText(submitButton, `${button} ${plural(selection.keys.length, 'track')}`);
    submitButton.disabled = selection.keys.length === 0;
  }

  function submit() {
    const { keys } = readSelection();
    const review = store.get().review;
    if (keys.length === 0 || review === null) return;
    const [value, , , verdictText] = verdict();
    const applied = reviewCommands(keys, value, review.frame).filter((command) => app.edit(command));
    if (applied.length === 0) return;
    toast(`${plural(keys.length, 'track')} ${verdictText}.`, {
      tone: 'good',
      action: { label: 'Undo', run: () => void app.editor.undo() },
    });
    close();
  }

  show();
  let docs = store.get().review?.docs;
  return {
    title: 'Bulk review of the shown tracks',
    size: 'narrow',
    submit,
    focus: choices[0].input,
    body: h(
      'div.stack',
      h(
        'p.muted',
        'Gives the same verdict to every track that passes the filters of the queue, including those outside the visible part. Ctrl+Z reverts it.',
      ),
      group('Verdict', h('div.ticks', ...choices.map(({ element }) => element))),
      openOnly.element,
      field('Maximum uncertainty, %', maxUncertaintyInput),
      shownText,
    ),
    footer: [errorText, h('button.btn', { onclick: close }, 'Cancel'), submitButton],
    update({ review }) {
      if (review?.docs === docs) return;
      docs = review?.docs;
      show();
    },
  };
}
