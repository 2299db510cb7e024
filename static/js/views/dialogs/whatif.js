// @ts-check
/** What-if: replays the stored evidence with other parameters and lists the differences. */

import { errorMessage } from '../../api/errors.js';
import { formatRoute } from '../../model/route.js';
import { runShare } from '../../model/run_progress.js';
import { putRun } from '../../store/actions/page.js';
import { fill, h, setText } from '../dom.js';
import { plural } from '../../model/format.js';
import { icon } from '../icons.js';
import { createParameterFields, presetValue } from '../parameter_fields.js';
import { replayWarning, runChanges, runInexact, runProgress } from '../../model/describe_run.js';
import { createChangeList } from '../whatif_changes.js';

/** @typedef {import('../../types.js').Run} Run */

/** @type {import('./index.js').CreateDialog<'whatif'>} */
export function whatIfDialog({ app, data, close, signal }) {
  const { store, api } = app;
  const state = store.get();
  const knownRuns = [...(state.review?.run ? [state.review.run] : []), ...Object.values(state.runs).flat()];
  const parent = knownRuns.find(({ id }) => id === (data.run ?? state.review?.run?.id));
  /** The run's own value of a parameter. @param {import('../../types.js').Parameter} parameter */
  const baseValue = (parameter) =>
    parent && Object.hasOwn(parent.parameters, parameter.name)
      ? parent.parameters[parameter.name]
      : presetValue(parameter, parent?.preset ?? 'default');
  const keepRadius = state.parameters.find(({ name }) => name === 'keep_radius');
  const parameterFields = createParameterFields({
    parameters: state.parameters.filter(({ replayable }) => replayable),
    initial: state.review?.tau !== null && state.review?.tau !== undefined ? { tau: state.review.tau } : {},
    base: baseValue,
    warn: (name, value) => replayWarning(name, value, keepRadius && baseValue(keepRadius)),
    onChange: check,
  });
  const errorText = h('p.field-error.grow', { role: 'alert' });
  const replayButton = h('button.btn.btn-primary', { type: 'submit' }, icon('whatif'), 'Replay');
  const resultElement = h('div.whatif-result', { role: 'status' });
  /** @type {string|null} */ let startedId = null;
  /** @type {Run|null} */ let shownRun = null;

  function check() {
    replayButton.disabled = !parent || parameterFields.invalid() > 0 || Object.keys(parameterFields.changes()).length === 0;
  }

  async function submit() {
    if (!parent || replayButton.disabled) return;
    replayButton.disabled = true;
    setText(errorText, '');
    try {
      const run = await app.load(() => api.whatIf(parent.id, { parameters: parameterFields.changes() }, { signal }), putRun);
      startedId = run.id;
      show(run);
      void pollRun(run.id);
    } catch (thrown) {
      if (!signal.aborted) setText(errorText, errorMessage(thrown));
    } finally {
      check();
    }
  }

  /**
   * Poll the run: the event stream is faster, but may be down.
   * @param {string} id
   */
  async function pollRun(id) {
    while (!signal.aborted && startedId === id && (shownRun === null || shownRun.state === 'queued' || shownRun.state === 'running')) {
      await new Promise((resolve) => setTimeout(resolve, 2000));
      if (signal.aborted) return;
      try {
        const run = await app.load(() => api.run(id, { signal }), putRun);
        setText(errorText, '');
        show(run);
      } catch (thrown) {
        if (!signal.aborted) setText(errorText, errorMessage(thrown));
      }
    }
  }

  /** @param {Run} run */
  function show(run) {
    if (shownRun === run) return;
    shownRun = run;
    if (run.state === 'complete') {
      fill(
        resultElement,
        h(
          'div.row',
          h('h3.grow', runChanges(run)),
          h(
            'a.btn.btn-small',
            { href: `${formatRoute({ screen: 'compare', a: `run:${run.parent_id}`, b: `run:${run.id}` })}`, onclick: close },
            icon('compare'),
            'Compare in figures',
          ),
        ),
        runInexact(run) && h('p.field-warning', runInexact(run)),
        createChangeList(app, run, { close }),
      );
    } else if (run.state === 'queued' || run.state === 'running') {
      fill(
        resultElement,
        h('p', run.state === 'queued' && !run.note ? 'The replay waits for a free worker.' : runProgress(run)),
        h('span.meter', { style: { '--part': `${runShare(run) * 100}%` } }, h('span')),
        h(
          'button.btn.btn-small',
          { onclick: () => api.cancelRun(run.id).catch((thrown) => setText(errorText, errorMessage(thrown))) },
          'Cancel',
        ),
      );
    } else {
      fill(resultElement, h('p.field-error', runProgress(run)));
    }
  }

  fill(
    resultElement,
    h(
      'div.empty',
      icon('whatif'),
      h('h3', 'See what would change'),
      h(
        'p',
        parent
          ? 'Change parameters and replay. Nothing is decoded or detected again, so it takes seconds; the run itself stays as it is.'
          : 'Open a complete run first: a what-if replays its evidence.',
      ),
    ),
  );
  check();
  return {
    title: `What if …${parent?.tracks ? ` (${plural(parent.tracks, 'track')})` : ''}`,
    size: 'wide',
    focus: parameterFields.focus,
    submit,
    body: h(
      'div.run-dialog',
      h('section.run-column', { 'aria-label': 'Parameters' }, parameterFields.element),
      h('section.run-column', { 'aria-label': 'What would change' }, resultElement),
    ),
    footer: [errorText, h('button.btn', { onclick: close }, 'Close'), replayButton],
    update(newState) {
      if (!startedId) return;
      const run = (parent && newState.runs[parent.video_id])?.find(({ id }) => id === startedId);
      if (run) show(run);
    },
  };
}
