// @ts-check
/** What-if: replays the stored evidence with other parameters and lists the differences. */

import { sentence } from '../../api/errors.js';
import { formatRoute } from '../../model/route.js';
import { runShare } from '../../model/run_progress.js';
import { putRun } from '../../store/actions/page.js';
import { fill, h, setText } from '../dom.js';
import { plural } from '../../model/format.js';
import { icon } from '../icons.js';
import { createParameters, presetValue } from '../parameters.js';
import { replayWarning, runChanges, runInexact, runProgress } from '../../model/describe_run.js';
import { changeList } from '../whatif.js';

/** @typedef {import('../../types.js').Run} Run */

/**
 * @param {import('./layer.js').Setup<'whatif'>} setup
 * @returns {import('./layer.js').Content}
 */
export function whatIfDialog({ app, data, close, signal }) {
  const { store, api } = app;
  const state = store.get();
  const known = [...(state.review?.run ? [state.review.run] : []), ...Object.values(state.runs).flat()];
  const parent = known.find(({ id }) => id === (data.run ?? state.review?.run?.id));
  /** The run's own value of a parameter. @param {import('../../types.js').Parameter} parameter */
  const base = (parameter) =>
    parent && Object.hasOwn(parent.parameters, parameter.name)
      ? parent.parameters[parameter.name]
      : presetValue(parameter, parent?.preset ?? 'default');
  const keep = state.parameters.find(({ name }) => name === 'keep_radius');
  const fields = createParameters({
    parameters: state.parameters.filter(({ replayable }) => replayable),
    initial: state.review?.tau !== null && state.review?.tau !== undefined ? { tau: state.review.tau } : {},
    base,
    warn: (name, value) => replayWarning(name, value, keep && base(keep)),
    onChange: check,
  });
  const error = h('p.field-error.grow', { role: 'alert' });
  const start = h('button.btn.btn-primary', { type: 'submit' }, icon('whatif'), 'Replay');
  const result = h('div.whatif-result', { role: 'status' });
  /** @type {string|null} */
  let started = null;
  /** @type {Run|null} */
  let shown = null;

  function check() {
    start.disabled = !parent || fields.invalid() > 0 || Object.keys(fields.changes()).length === 0;
  }

  async function submit() {
    if (!parent || start.disabled) return;
    start.disabled = true;
    setText(error, '');
    try {
      const run = await app.load(() => api.whatIf(parent.id, { parameters: fields.changes() }, { signal }), putRun);
      started = run.id;
      show(run);
      void follow(run.id);
    } catch (thrown) {
      if (!signal.aborted) setText(error, sentence(thrown));
    } finally {
      check();
    }
  }

  /**
   * Poll the run: the event stream is faster, but may be down.
   * @param {string} id
   */
  async function follow(id) {
    while (!signal.aborted && started === id && (shown === null || shown.state === 'queued' || shown.state === 'running')) {
      await new Promise((resolve) => setTimeout(resolve, 2000));
      if (signal.aborted) return;
      try {
        const run = await app.load(() => api.run(id, { signal }), putRun);
        setText(error, '');
        show(run);
      } catch (thrown) {
        if (!signal.aborted) setText(error, sentence(thrown));
      }
    }
  }

  /** @param {Run} run */
  function show(run) {
    if (shown === run) return;
    shown = run;
    if (run.state === 'complete') {
      fill(
        result,
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
        changeList(app, run, { close }),
      );
    } else if (run.state === 'queued' || run.state === 'running') {
      fill(
        result,
        h('p', run.state === 'queued' && !run.note ? 'The replay waits for a free worker.' : runProgress(run)),
        h('span.meter', { style: { '--part': `${runShare(run) * 100}%` } }, h('span')),
        h('button.btn.btn-small', { onclick: () => api.cancelRun(run.id).catch((thrown) => setText(error, sentence(thrown))) }, 'Cancel'),
      );
    } else {
      fill(result, h('p.field-error', runProgress(run)));
    }
  }

  fill(
    result,
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
    focus: fields.focus,
    submit,
    body: h(
      'div.run-dialog',
      h('section.run-column', { 'aria-label': 'Parameters' }, fields.element),
      h('section.run-column', { 'aria-label': 'What would change' }, result),
    ),
    footer: [error, h('button.btn', { onclick: close }, 'Close'), start],
    update(now) {
      if (!started) return;
      const run = (parent && now.runs[parent.video_id])?.find(({ id }) => id === started);
      if (run) show(run);
    },
  };
}
