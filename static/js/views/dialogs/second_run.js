// @ts-check
/** Choose another run of the video to show on top of the open one. */

import { overlayableRuns } from '../../model/second_run.js';
import { openDialog } from '../../store/actions/page.js';
import { h } from '../dom.js';
import { emptyState } from '../placeholders.js';
import { icon } from '../icons.js';
import { modelVersionSuffix } from '../model_version_text.js';
import { runTitle } from '../../model/describe_run.js';
import { choiceInput, group } from './fields.js';

/** @type {import('./index.js').CreateDialog<'second'>} */
export function secondRunDialog({ app, close }) {
  const { store } = app;
  const { review, runs, models } = store.get();
  const otherRuns = review ? overlayableRuns(runs[review.video.id] ?? [], review.run?.id ?? null) : [];
  const cancelButton = h('button.btn', { onclick: close }, 'Cancel');
  const title = 'Second run over this one';
  if (review === null || otherRuns.length === 0) {
    const runsButton = h(
      'button.btn.btn-primary',
      { onclick: () => review && store.dispatch(openDialog, { kind: 'run', data: { video: review.video.id } }) },
      icon('run'),
      'Runs',
    );
    return {
      title,
      size: 'narrow',
      focus: runsButton,
      footer: [h('span.grow'), cancelButton, runsButton],
      body: emptyState({
        icon: 'run',
        title: 'No other run yet',
        text: 'Start another run of this video, or a what-if: its results can then be shown on top of this one, with dashed boxes.',
      }),
    };
  }
  const shownId = review.second ?? otherRuns[0].id;
  const choices = [
    ...otherRuns.map((run) => ({ id: run.id, text: `${runTitle(run)}${modelVersionSuffix(run, models)}` })),
    { id: '', text: 'None' },
  ].map(({ id, text }) => choiceInput('radio', { name: 'second-run', value: id, checked: id === shownId }, text));
  const corrected = choiceInput(
    'checkbox',
    { checked: Object.keys(review.secondDocs).length > 0 },
    'With its corrections, instead of the engine’s results',
  );
  return {
    title,
    size: 'narrow',
    focus: choices.find(({ input }) => input.checked)?.input,
    body: h('div.stack', group('Run', h('div.stack', ...choices.map(({ element }) => element))), corrected.element),
    footer: [h('span.grow'), cancelButton, h('button.btn.btn-primary', { type: 'submit' }, 'Show')],
    submit() {
      const id = choices.find(({ input }) => input.checked)?.input.value || null;
      app.loader.showSecond(id, corrected.input.checked);
      close();
    },
  };
}
