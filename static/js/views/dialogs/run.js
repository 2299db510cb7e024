// @ts-check
/** The runs of a video, and a new one: preset, changed parameters, range of frames. */

import {ApiError, sentence} from '../../api/errors.js';
import {formatRoute} from '../../model/route.js';
import {resumable, runPart} from '../../model/run_progress.js';
import {dropRun, openDialog, putRun, setModels, setRuns} from '../../store/actions/page.js';
import {changeRun} from '../change_run.js';
import {fill, h, reconcile, setText} from '../dom.js';
import {moment, plural} from '../format.js';
import {icon} from '../icons.js';
import {modelsOf} from '../model-words.js';
import {createParameters, presetValue} from '../parameters.js';
import {runChanges, runInexact, runKind, runName, runProgress, runState, runTone} from '../run-words.js';
import {toast} from '../toasts.js';

/** @typedef {import('../../page-types.js').App} App */
/** @typedef {import('../../types.js').Run} Run */

/**
 * @param {import('./layer.js').Setup} setup   data: `{video}`
 * @returns {import('./layer.js').Content}
 */
export function runDialog(setup) {
  const {app, data, signal} = setup;
  const {store, api} = app;
  const video = store.get().videos?.find(({id}) => id === data.video) ?? store.get().review?.video;
  const list = h('ul', {class: 'run-list'});
  const none = h('p', {class: 'muted'}, 'No run yet. Start the first one: the presets are good for most videos.');
  const form = newRun(setup, video?.frames ?? null);
  /** @type {readonly Run[]|null|undefined} */
  let shown = null;
  /** @type {readonly import('../../types.js').ModelVersion[]|null} */
  let versions = null;

  app.load(() => api.runs(data.video, {signal}), (state, runs) => setRuns(state, data.video, runs)).catch((thrown) => {
    if (!signal.aborted) fill(none, sentence(thrown));
  });

  return {
    title: `Runs of ${video?.name ?? 'this video'}`, size: 'wide',
    body: h('div', {class: 'run-dialog'},
      h('section', {class: 'run-column', 'aria-labelledby': 'runs-title'}, h('h3', {id: 'runs-title'}, 'Runs'), none, list),
      h('section', {class: 'run-column', 'aria-labelledby': 'new-run-title'}, h('h3', {id: 'new-run-title'}, 'New run'), form.element)),
    footer: form.footer, submit: form.submit, focus: form.focus,
    update(state) {
      const runs = state.runs[data.video];
      if (runs === shown && state.models === versions) return;
      shown = runs;
      versions = state.models;
      none.hidden = Boolean(runs?.length);
      reconcile(list, runs ?? [], ({id}) => id, (run) => runItem(setup, run), (item, run) => showRun(setup, item, run));
    },
  };
}

/**
 * @param {import('./layer.js').Setup} setup
 * @param {Run} run
 */
function runItem({app, close, signal}, run) {
  return h('li', {class: 'run-item'},
    h('div', {class: 'row'}, h('strong', {class: 'run-name truncate'}), h('span', {class: 'badge run-badge'}), h('span', {class: 'grow'}), h('span', {class: 'muted small'}, moment(run.created))),
    h('p', {class: 'run-changes muted small'}), h('p', {class: 'run-progress small'}), h('p', {class: 'run-inexact field-warning'}),
    h('span', {class: 'meter run-meter', role: 'progressbar', 'aria-label': 'Progress', 'aria-valuemin': 0, 'aria-valuemax': 100}, h('span')),
    h('div', {class: 'row run-actions'},
      h('a', {class: 'btn btn-small run-open', href: formatRoute({screen: 'review', video: run.video_id, run: run.id, frame: null, track: null}), onclick: close}, 'Open'),
      h('button', {class: 'btn btn-small run-cancel', type: 'button', onclick: () => changeRun(app, () => app.api.cancelRun(run.id), signal)}, 'Cancel'),
      h('button', {class: 'btn btn-small run-resume', type: 'button', onclick: () => changeRun(app, () => app.api.resumeRun(run.id), signal)}, 'Go on'),
      h('button', {class: 'btn btn-small run-whatif', type: 'button', onclick: () => app.store.dispatch((state) => openDialog(state, {kind: 'whatif', data: {run: run.id}}))}, 'What if …'),
      h('button', {class: 'btn btn-small run-adopt', type: 'button', title: 'Bring the corrections that were made on this run to the run that is open', onclick: () => {
        const to = app.store.get().review?.run;
        if (to) app.store.dispatch((state) => openDialog(state, {kind: 'adopted', data: {from: run, to}}));
      }}, 'Bring its corrections'),
      h('span', {class: 'grow'}),
      h('button', {class: 'btn btn-small btn-quiet btn-icon', type: 'button', 'aria-label': `Remove ${runName(run)}`, title: 'Remove this run …', onclick: () => askRemove(app, run)}, icon('trash'))));
}

/**
 * @param {import('./layer.js').Setup} setup
 * @param {HTMLElement} item
 * @param {Run} run
 */
function showRun({app}, item, run) {
  /** @param {string} name */
  const part = (name) => /** @type {HTMLElement} */ (item.querySelector(`.run-${name}`));
  const open = run.state === 'queued' || run.state === 'running';
  setText(part('name'), run.name || runKind(run));
  setText(part('badge'), runState(run));
  part('badge').className = `badge run-badge ${runTone(run)}`;
  const range = run.first > 0 || run.stop !== null ? `frames ${run.first} to ${run.stop === null ? 'the end' : run.stop - 1}` : '';
  setText(part('changes'), [run.name ? runKind(run) : '', range, runChanges(run), modelsOf(run, app.store.get().models)].filter(Boolean).join(' · '));
  part('changes').hidden = !part('changes').textContent;
  setText(part('progress'), runProgress(run));
  setText(part('inexact'), runInexact(run));
  part('progress').classList.toggle('field-error', run.state === 'failed');
  part('meter').hidden = !open;
  part('meter').style.setProperty('--part', `${runPart(run) * 100}%`);
  part('meter').setAttribute('aria-valuenow', String(Math.round(runPart(run) * 100)));
  part('cancel').hidden = !open;
  part('resume').hidden = !resumable(run);
  part('whatif').hidden = run.state !== 'complete' || run.kind !== 'engine';
  const shown = app.store.get().review?.run;
  part('adopt').hidden = !shown || shown.id === run.id || shown.video_id !== run.video_id || shown.state !== 'complete' || run.state !== 'complete';
  part('open').hidden = run.state === 'queued';
}

/**
 * @param {App} app
 * @param {Run} run
 */
function askRemove(app, run) {
  app.store.dispatch((state) => openDialog(state, {kind: 'confirm', data: {
    title: 'Remove this run?', confirm: 'Remove', danger: true,
    text: `“${runName(run)}” goes, with its evidence, its what-ifs and all corrections and notes that were made on it. They cannot be brought back.`,
    note: 'The video, its other runs and its ground truth stay.',
    run: async () => {
      await app.api.removeRun(run.id);
      app.store.dispatch((now) => dropRun(now, run.id));
      toast('The run was removed.');
    },
  }}));
}

/**
 * @param {import('./layer.js').Setup} setup
 * @param {number|null} frames   of the video
 */
function newRun({app, data, signal, close}, frames) {
  const {session, parameters} = app.store.get();
  const presets = session?.presets ?? ['default'];
  const preset = h('select', {class: 'select', id: 'run-preset', onchange: () => fields.rebase((parameter) => presetValue(parameter, preset.value))}, ...presets.map((name) => h('option', {value: name}, name)));
  const name = h('input', {class: 'input', type: 'text', id: 'run-name', maxlength: 120, autocomplete: 'off', placeholder: 'optional'});
  const first = h('input', {class: 'input', type: 'text', inputmode: 'numeric', id: 'run-first', value: '0', autocomplete: 'off', 'aria-describedby': 'run-range-error', oninput: check});
  const last = h('input', {class: 'input', type: 'text', inputmode: 'numeric', id: 'run-last', autocomplete: 'off', placeholder: frames === null ? 'end' : String(frames - 1), 'aria-describedby': 'run-range-error', oninput: check});
  const rangeError = h('span', {class: 'field-error', id: 'run-range-error', role: 'alert'});
  const error = h('p', {class: 'field-error grow', role: 'alert'});
  const start = h('button', {class: 'btn btn-primary', type: 'submit'}, icon('run'), 'Start the run');
  const summary = h('summary', null, 'Parameters');
  const fields = createParameters({parameters, base: (parameter) => presetValue(parameter, preset.value), onChange: (changed) => {
    setText(summary, changed ? `Parameters: ${plural(changed, 'change')}` : 'Parameters');
    check();
  }});

  function range() {
    const from = first.value.trim() === '' ? 0 : Number(first.value);
    const to = last.value.trim() === '' ? null : Number(last.value);
    if (!Number.isInteger(from) || from < 0) return {error: 'The first frame is a whole number from 0.'};
    if (to !== null && (!Number.isInteger(to) || to < from)) return {error: `The last frame is a whole number from ${from}, or empty for the end.`};
    if (frames !== null && Math.max(from, to ?? 0) >= frames) return {error: `The video has the frames 0 to ${frames - 1}.`};
    return {first: from, stop: to === null ? null : to + 1};
  }

  function check() {
    const wrong = range().error ?? '';
    setText(rangeError, wrong);
    for (const input of [first, last]) input.setAttribute('aria-invalid', String(Boolean(wrong)));
    start.disabled = Boolean(wrong) || fields.invalid() > 0;
  }

  async function submit() {
    const wanted = range();
    if (wanted.error || fields.invalid()) return;
    start.disabled = true;
    setText(error, '');
    try {
      const run = await app.api.startRun(data.video, {preset: preset.value, parameters: fields.changes(), first: wanted.first, stop: wanted.stop, name: name.value.trim()}, {signal});
      app.store.dispatch((state) => putRun(state, run));
      toast('The run is started.', {tone: 'good', action: {label: 'Open', run: () => {
        close();
        location.hash = formatRoute({screen: 'review', video: run.video_id, run: run.id, frame: null, track: null});
      }}});
    } catch (thrown) {
      if (signal.aborted) return;
      const field = thrown instanceof ApiError && thrown.field ? `${thrown.field}: ` : '';
      setText(error, sentence(thrown).startsWith(field) ? sentence(thrown) : field + sentence(thrown));
    } finally {
      check();
    }
  }

  const models = h('p', {class: 'field-hint run-models'}, 'Models: …');
  app.load(() => app.api.models({signal}), setModels).then(
    (found) => {
      fill(models, 'Models: ', h('strong', null, found.find(({active}) => active)?.name ?? 'Shipped'), ', ', h('a', {href: '#/models', onclick: close}, 'choose another'));
    },
    () => {
      models.hidden = true; // the server chooses by itself
    });
  const element = h('div', {class: 'stack'},
    h('div', {class: 'run-fields'},
      h('div', {class: 'field'}, h('label', {class: 'field-label', for: 'run-preset'}, 'Preset'), preset),
      h('div', {class: 'field'}, h('label', {class: 'field-label', for: 'run-name'}, 'Name'), name),
      h('div', {class: 'field'}, h('label', {class: 'field-label', for: 'run-first'}, 'First frame'), first),
      h('div', {class: 'field'}, h('label', {class: 'field-label', for: 'run-last'}, 'Last frame'), last)),
    rangeError, models, h('details', {class: 'details'}, summary, fields.element));
  return {element, submit, focus: preset, footer: [error, h('button', {class: 'btn', type: 'button', onclick: close}, 'Close'), start]};
}
