// @ts-check
/** The runs of a video, and the form of a new run. */

import { errorMessage } from '../../api/errors.js';
import { runAddress } from '../../model/route.js';
import { listRuns } from '../../model/run_groups.js';
import { putRun } from '../../store/actions/page.js';
import { fill, h, reconcile } from '../dom.js';
import { toast } from '../../core/toast.js';
import { messageWithField } from './fields.js';
import { createRunForm } from './run_form.js';
import { createRunItem, updateRunItem } from './run_item.js';
import { createLabelSetField } from './video_label_set.js';
import { loadRuns } from '../load_runs.js';

/** @typedef {import('../../types.js').Run} Run */

/** @type {import('./index.js').CreateDialog<'run'>} */
export function runDialog(setup) {
  const { app, data, signal, close } = setup;
  const { store, api } = app;
  const video = store.get().videos?.find(({ id }) => id === data.video) ?? store.get().review?.video;
  const list = h('ul.run-list');
  const emptyText = h('p.muted', 'No run yet. Start the first one: the presets suit most videos.');
  const form = createRunForm(setup, { frames: video?.frames ?? null, several: false, buttonText: 'Start the run', send });
  /** @type {readonly Run[]|null|undefined} */ let shownRuns = null;
  /** @type {readonly import('../../types.js').ModelVersion[]|null} */ let shownVersions = null;

  /** @param {import('../../api/runs.js').RunRequest} request */
  async function send(request) {
    try {
      const run = await app.load(() => api.startRun(data.video, request, { signal }), putRun);
      toast('The run was started.', {
        tone: 'good',
        action: {
          label: 'Open',
          run: () => {
            location.hash = runAddress(store.get(), run.video_id, run.id);
          },
        },
      });
      close(); // the review and the card show the progress, and the notice can be clicked
      return '';
    } catch (thrown) {
      return messageWithField(thrown);
    }
  }

  loadRuns(app, data.video, { signal }).catch((thrown) => {
    if (!signal.aborted) fill(emptyText, errorMessage(thrown));
  });

  return {
    title: `Runs of ${video?.name ?? 'this video'}`,
    size: 'wide',
    body: h(
      'div.run-dialog',
      h(
        'section.run-column',
        { 'aria-labelledby': 'runs-title' },
        h('h3', { id: 'runs-title' }, 'Runs'),
        emptyText,
        list,
        video && createLabelSetField(app, video, signal),
      ),
      h('section.run-column', { 'aria-labelledby': 'new-run-title' }, h('h3', { id: 'new-run-title' }, 'New run'), form.element),
    ),
    footer: form.footer,
    submit: form.submit,
    focus: form.focus,
    update(state) {
      const runs = state.runs[data.video];
      if (runs === shownRuns && state.models === shownVersions) return;
      shownRuns = runs;
      shownVersions = state.models;
      emptyText.hidden = Boolean(runs?.length);
      reconcile(
        list,
        listRuns(runs ?? []),
        ({ run }) => run.id,
        ({ run }) => createRunItem(setup, run),
        (item, listed) => updateRunItem(setup, item, listed),
      );
    },
  };
}
