// @ts-check
/** Make a new model version from reviews, from exports of corrections, or from public data. */

import { errorMessage } from '../../api/errors.js';
import { parseNumber } from '../../model/exchange.js';
import { REVIEW_CHOICES, describeAge, defaultChoice, isChosen, describeReview } from '../../model/training_sources.js';
import { openDialog, putModel, setOutputs, setModels } from '../../store/actions/page.js';
import { fill, h, selectInput, setText } from '../dom.js';
import { moment } from '../../model/format.js';
import { icon } from '../icons.js';
import { describeContent } from '../output_text.js';
import { PART_NAMES } from '../model_version_text.js';
import { toast } from '../../core/toast.js';
import { choiceInput, field, group, messageWithField, numberInput, textInput } from './fields.js';

const PARTS = /** @type {const} */ ([
  ['detector', PART_NAMES.detector, 'Adds boosted trees to the earlier version.'],
  ['prior', PART_NAMES.prior, 'Where in the picture signs appear, and how large they are.'],
  ['lambda', PART_NAMES.lambda, 'Tuned again on the corrections.'],
  ['classifier', PART_NAMES.classifier, 'Keeps earlier knowledge by the stored training data.'],
  ['online', PART_NAMES.online, 'First samples of each class.'],
]);

/** @type {import('./index.js').CreateDialog<'retrain'>} */
export function retrainDialog({ app, data, close, signal }) {
  const { store, api } = app;
  const errorText = h('p.field-error.grow', { role: 'alert' });
  const submitButton = h('button.btn.btn-primary', { type: 'submit', disabled: true }, icon('run'), 'Retrain');
  const reviewList = h('ul.pick-list', { 'aria-label': 'Reviews to learn from' });
  const choiceSelect = selectInput({ id: 'retrain-which', onchange: selectReviews }, Object.entries(REVIEW_CHOICES));
  const noReviewText = h(
    'p.muted',
    'No run has corrections yet. Accept or correct some tracks first, or choose a file or public data below.',
  );
  const exportList = h('ul.pick-list', { 'aria-label': 'Exports to learn from' });
  const noExportText = h(
    'p.muted',
    'No complete export yet. ',
    h('button.btn-link', { onclick: () => store.dispatch(openDialog, { kind: 'export' }) }, 'Export corrections'),
    '.',
  );
  const partInputs = PARTS.map(([value, label, title]) =>
    choiceInput('checkbox', { value, checked: true, onchange: check }, h('span.kind-name', label), h('span.muted.small', title)),
  );
  const parentSelect = h('select.select', { id: 'retrain-parent' });
  const nameInput = textInput('retrain-name', { maxlength: 120, placeholder: 'optional' });
  const seedInput = numberInput('retrain-seed', '0', check, { inputmode: 'numeric' });
  const folderProps = { spellcheck: 'false', placeholder: 'optional', oninput: check };
  const gtsdbInput = textInput('retrain-gtsdb', folderProps);
  const gtsrbInput = textInput('retrain-gtsrb', folderProps);
  /** @type {unknown} */ let shownOutputs = null;
  /** @type {import('../../model/training_sources.js').ReviewSource[]} */ let sources = [];
  /** @type {import('../../model/training_sources.js').ExportAge[]} */ let exportAges = [];

  /** @param {HTMLElement} list */
  const checkedValues = (list) => [...list.querySelectorAll('input')].filter(({ checked }) => checked).map(({ value }) => value);
  const chosenExports = () => checkedValues(exportList);

  function findProblem() {
    if (checkedValues(reviewList).length === 0 && chosenExports().length === 0 && !gtsdbInput.value.trim() && !gtsrbInput.value.trim())
      return 'Select a review or an export, or name a folder.';
    if (!partInputs.some(({ input }) => input.checked)) return 'Select at least one part.';
    const found = parseNumber(seedInput.value, { name: 'The seed', low: 0, high: 2 ** 31 - 1, whole: true });
    return 'error' in found ? found.error : '';
  }

  /** Check the form. A missing choice is shown as an error only after the user has changed something. @param {Event} [event] */
  function check(event) {
    const problem = findProblem();
    submitButton.disabled = problem !== '';
    errorText.className = event ? 'field-error grow' : 'muted small grow';
    setText(errorText, problem);
  }

  async function submit() {
    if (findProblem()) return;
    submitButton.disabled = true;
    const folders = Object.fromEntries(
      [
        ['gtsdb', gtsdbInput.value.trim()],
        ['gtsrb', gtsrbInput.value.trim()],
      ].filter(([, path]) => path),
    );
    try {
      const version = await app.load(
        () =>
          api.train(
            {
              name: nameInput.value.trim(),
              parts: /** @type {import('../../types.js').ModelRequest['parts']} */ (
                partInputs.filter(({ input }) => input.checked).map(({ input }) => input.value)
              ),
              reviews: checkedValues(reviewList),
              exports: chosenExports(),
              folders,
              seed: Number(seedInput.value),
              parent: parentSelect.value || null,
            },
            { signal },
          ),
        putModel,
      );
      close();
      location.hash = '#/models';
      toast(`${version.name} is being made. Its card shows the progress.`, { tone: 'good' });
    } catch (thrown) {
      if (signal.aborted) return;
      setText(errorText, messageWithField(thrown));
      submitButton.disabled = false;
    }
  }

  /** Select exactly the videos of the chosen state. */
  function selectReviews() {
    for (const input of reviewList.querySelectorAll('input')) {
      const source = sources.find(({ run }) => run === input.value);
      input.checked =
        source !== undefined &&
        isChosen(source, /** @type {import('../../model/training_sources.js').ReviewChoice} */ (choiceSelect.value));
    }
    check();
  }

  function showReviews() {
    fill(
      reviewList,
      ...sources.map((source) =>
        h(
          'li.pick',
          h(
            'label.tick.grow',
            h('input', { type: 'checkbox', value: source.run, onchange: check }),
            h(
              'span.stack.made-text',
              h(
                'span.truncate',
                { title: source.run_name ? `${source.video_name}, ${source.run_name}` : source.video_name },
                source.video_name,
              ),
              h('span.muted.small', describeReview(source)),
            ),
          ),
        ),
      ),
    );
    reviewList.hidden = sources.length === 0;
    choiceField.hidden = reviewList.hidden;
    noReviewText.hidden = !reviewList.hidden;
    if (data.exports)
      check(); // a dialog opened from a file selects only that file
    else {
      choiceSelect.value = defaultChoice(sources);
      selectReviews();
    }
  }

  async function load() {
    try {
      ({ reviews: sources, exports: exportAges } = await api.trainingSources({ signal }));
      showReviews();
      const [, models] = await app.load(
        () => Promise.all([api.outputs({}, { signal }), api.models({ signal })]),
        (state, [files, versions]) => setModels(setOutputs(state, files), versions),
      );
      fill(
        parentSelect,
        ...models
          .filter(({ state }) => state === 'complete')
          .map((one) => h('option', { value: one.id }, one.active ? `${one.name} (in use)` : one.name)),
      );
      parentSelect.value = models.find(({ active }) => active)?.id ?? 'shipped';
    } catch (thrown) {
      if (!signal.aborted) setText(errorText, errorMessage(thrown));
    }
  }

  const choiceField = field('Videos', choiceSelect);
  const exportDetails = h(
    'details.details',
    { open: Boolean(data.exports) },
    h('summary', 'Exported files'),
    h('div.stack', exportList, noExportText),
  );
  for (const list of [reviewList, choiceField, noReviewText]) list.hidden = true;
  void load();
  return {
    title: 'Retrain',
    size: 'wide',
    submit,
    focus: nameInput,
    body: h(
      'div.run-dialog',
      h(
        'section.run-column',
        { 'aria-labelledby': 'retrain-from' },
        h('h3', { id: 'retrain-from' }, 'Learn from reviews'),
        choiceField,
        reviewList,
        noReviewText,
        exportDetails,
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
              gtsdbInput,
              'With reviews or exports, it is used for figures. Without them, the parts are trained on it from scratch, which takes long.',
            ),
            field('GTSRB folder', gtsrbInput),
          ),
        ),
      ),
      h(
        'section.run-column',
        { 'aria-labelledby': 'retrain-how' },
        h('h3', { id: 'retrain-how' }, 'How'),
        h('div.run-fields', field('Name', nameInput), field('Seed', seedInput)),
        field('Start from', parentSelect, 'It stays unchanged: a version never changes.'),
        group('Parts', h('div.kinds', ...partInputs.map(({ element }) => element))),
      ),
    ),
    footer: [errorText, h('button.btn', { onclick: close }, 'Cancel'), submitButton],
    update(state) {
      if (state.outputs === shownOutputs) return;
      const previouslyChosen = shownOutputs === null ? new Set(data.exports ?? []) : new Set(chosenExports());
      shownOutputs = state.outputs;
      const completeExports = (state.outputs ?? []).filter((output) => output.kind === 'export' && output.state === 'complete');
      fill(
        exportList,
        ...completeExports.map((output) =>
          h(
            'li.pick',
            h(
              'label.tick.grow',
              h('input', { type: 'checkbox', value: output.id, checked: previouslyChosen.has(output.id), onchange: check }),
              h(
                'span.stack.made-text',
                h('span.truncate', output.name),
                h('span.muted.small', [describeContent(output), moment(output.finished)].filter(Boolean).join(' · ')),
                h('span.field-warning.small', describeAge(exportAges.find(({ id }) => id === output.id))),
              ),
            ),
          ),
        ),
      );
      exportList.hidden = completeExports.length === 0;
      noExportText.hidden = completeExports.length > 0;
      check();
    },
  };
}
