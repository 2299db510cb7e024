// @ts-check
/** The runs of a video, and a new one: preset, changed parameters, range of frames. */

import {ApiError, sentence} from '../../api/errors.js';
import {formatRoute} from '../../model/route.js';
import {listRuns} from '../../model/run_groups.js';
import {putRun, setModels, setRuns} from '../../store/actions/page.js';
import {fill, h, reconcile, setText} from '../dom.js';
import {plural} from '../format.js';
import {icon} from '../icons.js';
import {createParameters, presetValue} from '../parameters.js';
import {toast} from '../toasts.js';
import {runItem, showRun} from './run-item.js';
import {createVideoLabels} from './video-labels.js';

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
      h('section', {class: 'run-column', 'aria-labelledby': 'runs-title'}, h('h3', {id: 'runs-title'}, 'Runs'), none, list, video && createVideoLabels(app, video, signal)),
      h('section', {class: 'run-column', 'aria-labelledby': 'new-run-title'}, h('h3', {id: 'new-run-title'}, 'New run'), form.element)),
    footer: form.footer, submit: form.submit, focus: form.focus,
    update(state) {
      const runs = state.runs[data.video];
      if (runs === shown && state.models === versions) return;
      shown = runs;
      versions = state.models;
      none.hidden = Boolean(runs?.length);
      reconcile(list, listRuns(runs ?? []), ({run}) => run.id, ({run}) => runItem(setup, run), (item, listed) => showRun(setup, item, listed));
    },
  };
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
      const order = {preset: preset.value, parameters: fields.changes(), first: wanted.first, stop: wanted.stop, name: name.value.trim()};
      const run = await app.load(() => app.api.startRun(data.video, order, {signal}), putRun);
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
