// @ts-check
/** Choose another run of the video to show on top of the open one. */

import { overlayableRuns } from '../../model/second_run.js';
import { openDialog } from '../../store/actions/page.js';
import { h } from '../dom.js';
import { emptyState } from '../empty.js';
import { icon } from '../icons.js';
import { modelsTag } from '../model-words.js';
import { runTitle } from '../../model/describe_run.js';
import { group, tick } from './fields.js';

/**
 * @param {import('./layer.js').Setup<'second'>} setup
 * @returns {import('./layer.js').Content}
 */
export function secondDialog({ app, close }) {
  const { store } = app;
  const { review, runs, models } = store.get();
  const others = review ? overlayableRuns(runs[review.video.id] ?? [], review.run?.id ?? null) : [];
  const cancel = h('button.btn', { onclick: close }, 'Cancel');
  const title = 'Second run over this one';
  if (review === null || others.length === 0) {
    const start = h(
      'button.btn.btn-primary',
      { onclick: () => review && store.dispatch(openDialog, { kind: 'run', data: { video: review.video.id } }) },
      icon('run'),
      'Runs',
    );
    return {
      title,
      size: 'narrow',
      focus: start,
      footer: [h('span.grow'), cancel, start],
      body: emptyState({
        icon: 'run',
        title: 'No other run yet',
        text: 'Start another run of this video, or a what-if: its results can then be shown on top of this one, with dashed boxes.',
      }),
    };
  }
  const present = review.second ?? others[0].id;
  const choices = [
    ...others.map((run) => ({ id: run.id, words: `${runTitle(run)}${modelsTag(run, models)}` })),
    { id: '', words: 'None' },
  ].map(({ id, words }) => tick('radio', { name: 'second-run', value: id, checked: id === present }, words));
  const corrected = tick(
    'checkbox',
    { checked: Object.keys(review.secondDocs).length > 0 },
    'With its corrections, instead of the engine’s results',
  );
  return {
    title,
    size: 'narrow',
    focus: choices.find(({ input }) => input.checked)?.input,
    body: h('div.stack', group('Run', h('div.stack', ...choices.map(({ element }) => element))), corrected.element),
    footer: [h('span.grow'), cancel, h('button.btn.btn-primary', { type: 'submit' }, 'Show')],
    submit() {
      const id = choices.find(({ input }) => input.checked)?.input.value || null;
      app.loader.showSecond(id, corrected.input.checked);
      close();
    },
  };
}
