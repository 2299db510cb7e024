// @ts-check
/** Make a new model version from exports of corrections, or from public data. */

import {ApiError, sentence} from '../../api/errors.js';
import {numberIn} from '../../model/exchange.js';
import {openDialog, putModel, setOutputs, setModels} from '../../store/actions/page.js';
import {fill, h, setText} from '../dom.js';
import {moment} from '../format.js';
import {icon} from '../icons.js';
import {content} from '../output-words.js';
import {PART_NAMES} from '../model-words.js';
import {toast} from '../toasts.js';
import {field, group, numberInput, tick} from './fields.js';

const PARTS = /** @type {const} */ ([
  ['detector', PART_NAMES.detector, 'Boosted trees go on from the earlier version.'],
  ['prior', PART_NAMES.prior, 'Where in the picture signs stand, and how large.'],
  ['lambda', PART_NAMES.lambda, 'Found again on the corrections.'],
  ['classifier', PART_NAMES.classifier, 'Keeps what it knew by the memory of its training data.'],
  ['online', PART_NAMES.online, 'First samples of each class.'],
]);

/**
 * @param {import('./layer.js').Setup} setup   data: `{exports?: string[]}`: those that are ticked at first
 * @returns {import('./layer.js').Content}
 */
export function retrainDialog({app, data, close, signal}) {
  const {store, api} = app;
  const error = h('p', {class: 'field-error grow', role: 'alert'});
  const go = h('button', {class: 'btn btn-primary', type: 'submit', disabled: true}, icon('run'), 'Retrain');
  const exports = h('ul', {class: 'pick-list', 'aria-label': 'Exports to learn from'});
  const none = h('p', {class: 'muted'}, 'No complete export yet. ', h('button', {class: 'btn-link', type: 'button', onclick: () => store.dispatch((state) => openDialog(state, {kind: 'export'}))}, 'Export corrections first'), ', or name folders of public data below.');
  const parts = PARTS.map(([value, label, title]) => tick('checkbox', {value, checked: true, onchange: check}, h('span', {class: 'kind-name'}, label), h('span', {class: 'muted small'}, title)));
  const parent = h('select', {class: 'select', id: 'retrain-parent'});
  const name = h('input', {class: 'input', type: 'text', id: 'retrain-name', maxlength: 120, autocomplete: 'off', placeholder: 'optional'});
  const seed = numberInput('retrain-seed', '0', check, {inputmode: 'numeric'});
  const gtsdb = h('input', {class: 'input', type: 'text', id: 'retrain-gtsdb', autocomplete: 'off', spellcheck: 'false', placeholder: 'optional', oninput: check});
  const gtsrb = h('input', {class: 'input', type: 'text', id: 'retrain-gtsrb', autocomplete: 'off', spellcheck: 'false', placeholder: 'optional', oninput: check});
  /** @type {unknown} */
  let shown = null;

  const chosen = () => [...exports.querySelectorAll('input')].filter(({checked}) => checked).map(({value}) => value);

  function problem() {
    if (chosen().length === 0 && !gtsdb.value.trim() && !gtsrb.value.trim()) return 'Tick an export, or name a folder.';
    if (!parts.some(({input}) => input.checked)) return 'Tick at least one part.';
    const found = numberIn(seed.value, {name: 'The seed', low: 0, high: 2 ** 31 - 1, whole: true});
    return 'error' in found ? found.error : '';
  }

  /** What is still missing is no error before anybody has touched anything. @param {Event} [event] */
  function check(event) {
    const wrong = problem();
    go.disabled = wrong !== '';
    error.className = event ? 'field-error grow' : 'muted small grow';
    setText(error, wrong);
  }

  async function submit() {
    if (problem()) return;
    go.disabled = true;
    const folders = Object.fromEntries([['gtsdb', gtsdb.value.trim()], ['gtsrb', gtsrb.value.trim()]].filter(([, path]) => path));
    try {
      const version = await app.load(() => api.train({
        name: name.value.trim(),
        parts: /** @type {import('../../types.js').ModelRequest['parts']} */ (parts.filter(({input}) => input.checked).map(({input}) => input.value)),
        exports: chosen(), folders, seed: Number(seed.value), parent: parent.value || null,
      }, {signal}), putModel);
      close();
      location.hash = '#/models';
      toast(`${version.name} is being made. Its card shows how far it is.`, {tone: 'good'}); // there
    } catch (thrown) {
      if (signal.aborted) return;
      const where = thrown instanceof ApiError && thrown.field ? `${thrown.field}: ` : '';
      setText(error, sentence(thrown).startsWith(where) ? sentence(thrown) : where + sentence(thrown));
      go.disabled = false;
    }
  }

  async function load() {
    try {
      const [, models] = await app.load(() => Promise.all([api.outputs({}, {signal}), api.models({signal})]),
        (state, [files, versions]) => setModels(setOutputs(state, files), versions));
      fill(parent, ...models.filter(({state}) => state === 'complete').map((one) => h('option', {value: one.id}, one.active ? `${one.name} (in use)` : one.name)));
      parent.value = models.find(({active}) => active)?.id ?? 'shipped';
    } catch (thrown) {
      if (!signal.aborted) setText(error, sentence(thrown));
    }
  }

  void load();
  return {
    title: 'Retrain', size: 'wide', submit, focus: name,
    body: h('div', {class: 'run-dialog'},
      h('section', {class: 'run-column', 'aria-labelledby': 'retrain-from'}, h('h3', {id: 'retrain-from'}, 'Learn from'), exports, none,
        h('p', {class: 'field-hint'}, 'Tracks that people have accepted, corrected or drawn teach signs. The new version learns from all of them; its figures are those of a trial version that learns without some, and is measured on these.'),
        h('p', {class: 'field-hint'}, 'Background is what no track covers in a reviewed video, false positives, and labels that the set counts as background. Open tracks, ignored ones, those that are not in the set, and labels that teach nothing are left alone: neither sign nor background.'),
        h('details', {class: 'details'}, h('summary', null, 'Public data on this machine'), h('div', {class: 'stack'},
          field('GTSDB folder', gtsdb, 'With exports it gives figures; without any, the parts are trained on it from the start, which takes long.'), field('GTSRB folder', gtsrb)))),
      h('section', {class: 'run-column', 'aria-labelledby': 'retrain-how'}, h('h3', {id: 'retrain-how'}, 'How'),
        h('div', {class: 'run-fields'}, field('Name', name), field('Seed', seed)), field('Start from', parent, 'It stays as it is: a version never changes.'),
        group('Parts', h('div', {class: 'kinds'}, ...parts.map(({element}) => element))))),
    footer: [error, h('button', {class: 'btn', type: 'button', onclick: close}, 'Cancel'), go],
    update(state) {
      if (state.outputs === shown) return;
      const before = shown === null ? new Set(data.exports ?? []) : new Set(chosen());
      shown = state.outputs;
      const usable = (state.outputs ?? []).filter((one) => one.kind === 'export' && one.state === 'complete');
      fill(exports, ...usable.map((one) => h('li', {class: 'pick'}, h('label', {class: 'tick grow'}, h('input', {type: 'checkbox', value: one.id, checked: before.has(one.id), onchange: check}),
        h('span', {class: 'stack made-text'}, h('span', {class: 'truncate'}, one.name), h('span', {class: 'muted small'}, [content(one), moment(one.finished)].filter(Boolean).join(' · ')))))));
      exports.hidden = usable.length === 0;
      none.hidden = usable.length > 0;
      check();
    },
  };
}
