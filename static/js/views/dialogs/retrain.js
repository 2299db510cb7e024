// @ts-check
/** Make a new model version from reviews, from exports of corrections, or from public data. */

import { ApiError, sentence } from '../../api/errors.js';
import { parseNumber } from '../../model/exchange.js';
import { REVIEW_CHOICES, describeAge, defaultChoice, isChosen, describeReview } from '../../model/training_sources.js';
import { openDialog, putModel, setOutputs, setModels } from '../../store/actions/page.js';
import { fill, h, setText } from '../dom.js';
import { moment } from '../../model/format.js';
import { icon } from '../icons.js';
import { content } from '../output-words.js';
import { PART_NAMES } from '../model-words.js';
import { toast } from '../../core/toast.js';
import { field, group, numberInput, tick } from './fields.js';

const PARTS = /** @type {const} */ ([
  ['detector', PART_NAMES.detector, 'Adds boosted trees to the earlier version.'],
  ['prior', PART_NAMES.prior, 'Where in the picture signs appear, and how large they are.'],
  ['lambda', PART_NAMES.lambda, 'Tuned again on the corrections.'],
  ['classifier', PART_NAMES.classifier, 'Keeps earlier knowledge by the stored training data.'],
  ['online', PART_NAMES.online, 'First samples of each class.'],
]);

/**
 * @param {import('./layer.js').Setup<'retrain'>} setup
 * @returns {import('./layer.js').Content}
 */
export function retrainDialog({ app, data, close, signal }) {
  const { store, api } = app;
  const error = h('p.field-error.grow', { role: 'alert' });
  const go = h('button.btn.btn-primary', { type: 'submit', disabled: true }, icon('run'), 'Retrain');
  const reviews = h('ul.pick-list', { 'aria-label': 'Reviews to learn from' });
  const which = h(
    'select.select',
    { id: 'retrain-which', onchange: () => tickReviews() },
    ...Object.entries(REVIEW_CHOICES).map(([value, text]) => h('option', { value }, text)),
  );
  const noReview = h('p.muted', 'No run has corrections yet. Accept or correct some tracks first, or choose a file or public data below.');
  const exports = h('ul.pick-list', { 'aria-label': 'Exports to learn from' });
  const none = h(
    'p.muted',
    'No complete export yet. ',
    h('button.btn-link', { onclick: () => store.dispatch(openDialog, { kind: 'export' }) }, 'Export corrections'),
    '.',
  );
  const parts = PARTS.map(([value, label, title]) =>
    tick('checkbox', { value, checked: true, onchange: check }, h('span.kind-name', label), h('span.muted.small', title)),
  );
  const parent = h('select.select', { id: 'retrain-parent' });
  const name = h('input.input', { type: 'text', id: 'retrain-name', maxlength: 120, autocomplete: 'off', placeholder: 'optional' });
  const seed = numberInput('retrain-seed', '0', check, { inputmode: 'numeric' });
  const gtsdb = h('input.input', {
    type: 'text',
    id: 'retrain-gtsdb',
    autocomplete: 'off',
    spellcheck: 'false',
    placeholder: 'optional',
    oninput: check,
  });
  const gtsrb = h('input.input', {
    type: 'text',
    id: 'retrain-gtsrb',
    autocomplete: 'off',
    spellcheck: 'false',
    placeholder: 'optional',
    oninput: check,
  });
  /** @type {unknown} */
  let shown = null;
  /** @type {import('../../model/training_sources.js').ReviewSource[]} */
  let sources = [];
  /** @type {import('../../model/training_sources.js').ExportAge[]} */
  let ages = [];

  /** @param {HTMLElement} list */
  const ticked = (list) => [...list.querySelectorAll('input')].filter(({ checked }) => checked).map(({ value }) => value);
  const chosen = () => ticked(exports);

  function problem() {
    if (ticked(reviews).length === 0 && chosen().length === 0 && !gtsdb.value.trim() && !gtsrb.value.trim())
      return 'Select a review or an export, or name a folder.';
    if (!parts.some(({ input }) => input.checked)) return 'Select at least one part.';
    const found = parseNumber(seed.value, { name: 'The seed', low: 0, high: 2 ** 31 - 1, whole: true });
    return 'error' in found ? found.error : '';
  }

  /** Check the form. A missing choice is shown as an error only after the user has changed something. @param {Event} [event] */
  function check(event) {
    const wrong = problem();
    go.disabled = wrong !== '';
    error.className = event ? 'field-error grow' : 'muted small grow';
    setText(error, wrong);
  }

  async function submit() {
    if (problem()) return;
    go.disabled = true;
    const folders = Object.fromEntries(
      [
        ['gtsdb', gtsdb.value.trim()],
        ['gtsrb', gtsrb.value.trim()],
      ].filter(([, path]) => path),
    );
    try {
      const version = await app.load(
        () =>
          api.train(
            {
              name: name.value.trim(),
              parts: /** @type {import('../../types.js').ModelRequest['parts']} */ (
                parts.filter(({ input }) => input.checked).map(({ input }) => input.value)
              ),
              reviews: ticked(reviews),
              exports: chosen(),
              folders,
              seed: Number(seed.value),
              parent: parent.value || null,
            },
            { signal },
          ),
        putModel,
      );
      close();
      location.hash = '#/models';
      toast(`${version.name} is being made. Its card shows the progress.`, { tone: 'good' }); // there
    } catch (thrown) {
      if (signal.aborted) return;
      const where = thrown instanceof ApiError && thrown.field ? `${thrown.field}: ` : '';
      setText(error, sentence(thrown).startsWith(where) ? sentence(thrown) : where + sentence(thrown));
      go.disabled = false;
    }
  }

  /** Select exactly the videos of the chosen state. */
  function tickReviews() {
    for (const input of reviews.querySelectorAll('input')) {
      const source = sources.find(({ run }) => run === input.value);
      input.checked =
        source !== undefined && isChosen(source, /** @type {import('../../model/training_sources.js').ReviewChoice} */ (which.value));
    }
    check();
  }

  function showReviews() {
    fill(
      reviews,
      ...sources.map((one) =>
        h(
          'li.pick',
          h(
            'label.tick.grow',
            h('input', { type: 'checkbox', value: one.run, onchange: check }),
            h(
              'span.stack.made-text',
              h('span.truncate', { title: one.run_name ? `${one.video_name}, ${one.run_name}` : one.video_name }, one.video_name),
              h('span.muted.small', describeReview(one)),
            ),
          ),
        ),
      ),
    );
    reviews.hidden = sources.length === 0;
    choice.hidden = reviews.hidden;
    noReview.hidden = !reviews.hidden;
    if (data.exports)
      check(); // a dialog opened from a file selects only that file
    else {
      which.value = defaultChoice(sources);
      tickReviews();
    }
  }

  async function load() {
    try {
      ({ reviews: sources, exports: ages } = await api.trainingSources({ signal }));
      showReviews();
      const [, models] = await app.load(
        () => Promise.all([api.outputs({}, { signal }), api.models({ signal })]),
        (state, [files, versions]) => setModels(setOutputs(state, files), versions),
      );
      fill(
        parent,
        ...models
          .filter(({ state }) => state === 'complete')
          .map((one) => h('option', { value: one.id }, one.active ? `${one.name} (in use)` : one.name)),
      );
      parent.value = models.find(({ active }) => active)?.id ?? 'shipped';
    } catch (thrown) {
      if (!signal.aborted) setText(error, sentence(thrown));
    }
  }

  const choice = field('Videos', which);
  const files = h('details.details', { open: Boolean(data.exports) }, h('summary', 'Exported files'), h('div.stack', exports, none));
  for (const list of [reviews, choice, noReview]) list.hidden = true;
  void load();
  return {
    title: 'Retrain',
    size: 'wide',
    submit,
    focus: name,
    body: h(
      'div.run-dialog',
      h(
        'section.run-column',
        { 'aria-labelledby': 'retrain-from' },
        h('h3', { id: 'retrain-from' }, 'Learn from reviews'),
        choice,
        reviews,
        noReview,
        files,
        h(
          'p.field-hint',
          'Accepted, corrected and drawn tracks are training signs. The new version learns from all of them. Its figures come from a trial version that is trained without some signs and measured on these.',
        ),
        h(
          'p.field-hint',
          'Background is everything outside the tracks of a reviewed video, false positives, and labels marked as background. Open and ignored tracks, tracks not in the set, and labels not used in training count as neither sign nor background.',
        ),
        h(
          'details.details',
          h('summary', 'Public data on this machine'),
          h(
            'div.stack',
            field(
              'GTSDB folder',
              gtsdb,
              'With reviews or exports, it is used for figures. Without them, the parts are trained on it from scratch, which takes long.',
            ),
            field('GTSRB folder', gtsrb),
          ),
        ),
      ),
      h(
        'section.run-column',
        { 'aria-labelledby': 'retrain-how' },
        h('h3', { id: 'retrain-how' }, 'How'),
        h('div.run-fields', field('Name', name), field('Seed', seed)),
        field('Start from', parent, 'It stays unchanged: a version never changes.'),
        group('Parts', h('div.kinds', ...parts.map(({ element }) => element))),
      ),
    ),
    footer: [error, h('button.btn', { onclick: close }, 'Cancel'), go],
    update(state) {
      if (state.outputs === shown) return;
      const before = shown === null ? new Set(data.exports ?? []) : new Set(chosen());
      shown = state.outputs;
      const usable = (state.outputs ?? []).filter((one) => one.kind === 'export' && one.state === 'complete');
      fill(
        exports,
        ...usable.map((one) =>
          h(
            'li.pick',
            h(
              'label.tick.grow',
              h('input', { type: 'checkbox', value: one.id, checked: before.has(one.id), onchange: check }),
              h(
                'span.stack.made-text',
                h('span.truncate', one.name),
                h('span.muted.small', [content(one), moment(one.finished)].filter(Boolean).join(' · ')),
                h('span.field-warning.small', describeAge(ages.find(({ id }) => id === one.id))),
              ),
            ),
          ),
        ),
      );
      exports.hidden = usable.length === 0;
      none.hidden = usable.length > 0;
      check();
    },
  };
}
