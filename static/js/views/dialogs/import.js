// @ts-check
/** Import a file of another tool onto a video: as corrections, as ground truth or as a run. */

import { ApiError, errorMessage } from '../../api/errors.js';
import { namedSwitches } from '../../model/exchange.js';
import { parseLabelMap } from '../../model/label_mapping.js';
import { formatRoute } from '../../model/route.js';
import { putRun } from '../../store/actions/page.js';
import { skippedListItems } from '../output_row.js';
import { fill, h, selectInput, setText } from '../dom.js';
import { bytes, count, plural } from '../../model/format.js';
import { icon } from '../icons.js';
import { showInReview } from '../show_in_review.js';
import { recall, remember, authorName } from '../../core/preferences.js';
import { runTitle } from '../../model/describe_run.js';
import { toast } from '../../core/toast.js';
import { createDropField } from './drop_field.js';
import { choiceInput, field, group, switchLabel, textInput } from './fields.js';
import { createLabelMapping } from './import_label_mapping.js';
import { createImportProgress, reportClosed } from './import_progress.js';
import { loadRuns } from '../load_runs.js';

/** @typedef {import('../../types.js').Format} Format */
/** @typedef {import('../../types.js').ImportResult} ImportResult */

const KINDS = /** @type {const} */ ([
  ['annotation', 'Corrections', 'Merged into a run, track by track. One undo reverts all of it.'],
  ['truth', 'Ground truth', 'A separate layer that runs are compared with.'],
  ['run', 'Run', 'Somebody else’s detector or tracker, shown and compared like a run of the engine.'],
]);

const SHOW = { annotation: 'Show the corrected run', truth: 'Show the ground truth', run: 'Show the run' };

/** @type {import('./index.js').CreateDialog<'import'>} */
export function importDialog({ app, data, close, signal }) {
  const { store, api } = app;
  const video = store.get().videos?.find(({ id }) => id === data.video) ?? store.get().review?.video;
  /** @type {Format[]} */ let formats = [];
  const errorText = h('p.field-error.grow', { role: 'alert' });
  const refusalElement = h('div.import-refused', { role: 'alert', hidden: true });
  const progress = createImportProgress({ api });
  const submitButton = h('button.btn.btn-primary', { type: 'submit', disabled: true }, icon('add'), 'Import');
  const fileField = createDropField({
    id: 'import-file',
    label: 'File',
    hint: 'XML, JSON, CSV, TXT, or a ZIP that contains all files. You can also drop it here.',
    onChange: () => {
      if (!nameInput.dataset.typed)
        nameInput.value =
          fileField
            .file()
            ?.name.replace(/\.(zip|xml|json|csv|txt|jsonl)$/i, '')
            .slice(0, 120) ?? '';
      refusalElement.hidden = true;
      check();
    },
  });
  const initialKind = data.as ?? recall('import.as') ?? 'truth';
  const kinds = KINDS.map(([value, label, title]) =>
    choiceInput(
      'radio',
      { name: 'import-as', value, checked: value === initialKind, onchange: check },
      h('span.kind-name', label),
      h('span.muted.small', title),
    ),
  );
  const runSelect = h('select.select', { id: 'import-run', onchange: check });
  const runField = field('Run to correct', runSelect);
  const nameInput = textInput('import-name', {
    maxlength: 120,
    oninput: () => {
      nameInput.dataset.typed = 'yes';
      check();
    },
  });
  const nameField = field('Name', nameInput, 'A ground truth of the same name is replaced.');
  const formatSelect = selectInput({ id: 'import-format', onchange: showFormat }, [['', 'detected from the file']]);
  const summary = h('p.muted.small');
  const switches = h('div.stack');
  const mappingInput = h('textarea.textarea', {
    id: 'import-names',
    rows: 3,
    spellcheck: 'false',
    placeholder: 'stop sign = stop',
    oninput: check,
  });
  const resultElement = h('div.stack', { hidden: true });
  /** @type {ImportResult|null} */ let imported = null;
  let isImporting = false;
  /** The labels of the video’s set. @type {readonly import('../../types.js').Label[]} */
  let labels = store.get().labels;
  /** The names that must be mapped first. @type {ReturnType<typeof createLabelMapping>|null} */
  let mapping = null;
  const mappingElement = h('div.stack', { hidden: true });
  const backButton = h('button.btn', { hidden: true, onclick: () => showMapping(null) }, 'Back');
  const form = h(
    'div.stack',
    fileField.element,
    group('Import as', h('div.kinds', ...kinds.map(({ element }) => element))),
    h('div.run-fields', runField, nameField, h('div.stack', field('Format', formatSelect), summary)),
    switches,
    h(
      'details.details',
      h('summary', 'Names of the file'),
      field(
        'One per line: name = label',
        mappingInput,
        'For names without a matching label, the dialog asks with examples before anything is stored.',
      ),
    ),
    refusalElement,
  );

  const chosenKind = () => kinds.find(({ input }) => input.checked)?.input.value ?? 'truth';
  /** @returns {'annotation'|'truth'|'run'} */
  const importKind = () => /** @type {'annotation'|'truth'|'run'} */ (chosenKind());

  function showFormat() {
    const chosen = formats.find((one) => one.name === formatSelect.value);
    setText(summary, chosen?.summary ?? '');
    fill(switches, ...(chosen?.import_switches ?? []).map((option) => field(switchLabel(option.name), createControl(option), option.help)));
    check();
  }

  /** @param {import('../../types.js').Switch} option */
  function createControl({ name, values, free }) {
    const props = { id: `import-switch-${name}`, dataset: { name } };
    if (free) return textInput(props.id, { ...props, value: values[0] });
    return selectInput(
      props,
      values.map((value) => [value, value]),
    );
  }

  function findProblem() {
    const file = fileField.file();
    const maxBytes = store.get().session?.upload_bytes;
    if (!file) return 'Choose a file.';
    if (maxBytes !== undefined && file.size > maxBytes) return `The file has ${bytes(file.size)}; at most ${bytes(maxBytes)} are allowed.`;
    if (importKind() === 'annotation' && !runSelect.value) return 'There is no complete run to correct yet.';
    if (importKind() !== 'annotation' && !nameInput.value.trim()) return 'Give it a name.';
    const labelMap = parseLabelMap(mappingInput.value, labels);
    if ('error' in labelMap) return labelMap.error;
    const mappingAnswers = mapping?.read();
    return mappingAnswers && 'error' in mappingAnswers ? mappingAnswers.error : '';
  }

  function check() {
    runField.hidden = importKind() !== 'annotation';
    nameField.hidden = importKind() === 'annotation';
    const problem = findProblem();
    submitButton.disabled = isImporting || problem !== '';
    setText(errorText, fileField.file() ? problem : '');
  }

  async function submit() {
    const file = fileField.file();
    const labelMap = parseLabelMap(mappingInput.value, labels);
    const mappingAnswers = mapping?.read() ?? { map: {}, add: [], skip: [] };
    if (isImporting || !file || findProblem() !== '' || 'error' in labelMap || 'error' in mappingAnswers) return;
    submitButton.disabled = isImporting = true;
    refusalElement.hidden = true;
    remember('import.as', chosenKind());
    const controls = /** @type {NodeListOf<HTMLInputElement|HTMLSelectElement>} */ (switches.querySelectorAll('select, input'));
    const switchValues = Object.fromEntries(
      [...controls].filter(({ value }) => value.trim() !== '').map((control) => [control.dataset.name ?? '', control.value.trim()]),
    );
    try {
      const unknown = mappingAnswers.skip.length ? 'skip' : mappingAnswers.add.length ? 'add' : 'refuse';
      const result = await progress.during(signal, ({ progress: progressName, sending }) =>
        api.importFile(
          data.video,
          file,
          {
            progress: progressName,
            as: importKind(),
            format: formatSelect.value || null,
            run: importKind() === 'annotation' ? runSelect.value : null,
            name: importKind() === 'annotation' ? file.name.replaceAll('/', '_').slice(0, 120) : nameInput.value.trim(),
            switches: JSON.stringify(switchValues),
            label_map: JSON.stringify({ ...labelMap.map, ...mappingAnswers.map }),
            unknown,
            add: JSON.stringify(mappingAnswers.add),
            author: authorName(app.store.get().session),
          },
          sending,
        ),
      );
      setText(errorText, '');
      if (mappingAnswers.add.length) await app.labels.reload();
      await show(result);
    } catch (thrown) {
      if (signal.aborted) {
        if (imported === null) reportClosed(file.name);
        return;
      }
      isImporting = false;
      setText(errorText, '');
      if (thrown instanceof ApiError && thrown.code === 'unknown_labels' && Array.isArray(thrown.details.labels)) {
        showMapping(thrown.details.labels);
        return;
      }
      check();
      if (mapping !== null) {
        setText(errorText, errorMessage(thrown));
        return;
      }
      refusalElement.hidden = false;
      // the switches of a format appear when it is chosen
      const options = formatSelect.value ? [] : namedSwitches(errorMessage(thrown), formats).map((name) => `“${switchLabel(name)}”`);
      fill(
        refusalElement,
        icon('alert'),
        h(
          'div.stack',
          h(
            'strong',
            { bad_file: 'The file breaks a rule', cancelled: 'Cancelled' }[thrown instanceof ApiError ? thrown.code : ''] ??
              'The import failed',
          ),
          h('p', errorMessage(thrown)),
          options.length > 0 && h('p', `To set ${options.join(' or ')}, choose the format of the file above.`),
        ),
      );
      refusalElement.scrollIntoView({ block: 'nearest' });
    }
  }

  /** Ask how to map names; null: show the form again. @param {import('../../types.js').UnknownLabel[]|null} unknown */
  function showMapping(unknown) {
    mapping = unknown && createLabelMapping({ api, video: data.video, unknown, labels, onChange: check, signal });
    fill(mappingElement, mapping?.element);
    form.hidden = mapping !== null;
    mappingElement.hidden = backButton.hidden = mapping === null;
    check();
    /** @type {HTMLElement|null} */ (mappingElement.querySelector('select'))?.focus();
  }

  /** @param {ImportResult} result */
  async function show(result) {
    imported = result;
    if (result.kind === 'run') {
      await app.load(() => api.run(result.id, { signal }), putRun);
    } else if (result.kind === 'annotation') {
      if (store.get().review?.run?.id === result.id) await app.editor.refresh();
    } else if (store.get().review?.video.id === data.video) {
      app.loader.showTruth(result.id);
    }
    const summaryText = [
      `${plural(result.tracks, 'track')} with ${plural(result.boxes, 'box', 'boxes')}`,
      result.same ? `${plural(result.same, 'further track')} the same as before` : '',
    ]
      .filter(Boolean)
      .join('; ');
    if (data.back && result.repaired.length + result.skipped.length === 0) {
      toast(`Imported: ${summaryText}.`, { tone: 'good' });
      close();
      return;
    }
    form.hidden = mappingElement.hidden = backButton.hidden = true;
    resultElement.hidden = false;
    submitButton.hidden = true;
    fill(
      resultElement,
      h('p.import-done', { role: 'status' }, icon('check'), h('strong', `Imported: ${summaryText}.`)),
      result.repaired.length > 0 &&
        h(
          'section.stack',
          h('h3', `Changed (${count(result.repaired.length)})`),
          h('ul.skipped-list.small', ...result.repaired.map((text) => h('li', text))),
        ),
      result.skipped.length > 0 &&
        h(
          'section.stack',
          h('h3', `Skipped (${count(result.skipped.length)})`),
          h('ul.skipped-list.small', ...skippedListItems(result.skipped, result.skipped.length)),
        ),
      h(
        'div.row',
        h(
          'button.btn.btn-primary',
          { onclick: () => (data.back ? close() : open(result)) },
          icon('eye'),
          data.back ? 'Back to the comparison' : SHOW[result.kind],
        ),
      ),
    );
    resultElement.querySelector('button')?.focus();
  }

  /** @param {ImportResult} result */
  function open(result) {
    const { review } = store.get();
    close();
    const isOpen = review?.video.id === data.video;
    if (result.kind === 'truth') {
      if (isOpen) return;
      location.hash = formatRoute({ screen: 'review', video: data.video, run: null, frame: null, track: null });
      showInReview(app, null, { truth: result.id, video: data.video });
      return;
    }
    location.hash = formatRoute({
      screen: 'review',
      video: data.video,
      run: result.id,
      frame: isOpen && review ? review.frame : null,
      track: null,
    });
  }

  async function load() {
    try {
      const [allFormats, videoLabels, runs] = await Promise.all([
        api.formats({ signal }),
        api.labels(video?.label_set ? video.id : null, { signal }),
        loadRuns(app, data.video, { signal }),
      ]);
      labels = videoLabels;
      formats = allFormats.filter(({ can_import }) => can_import);
      formatSelect.append(...formats.map((one) => h('option', { value: one.name }, one.title)));
      const completeRuns = runs.filter(({ state }) => state === 'complete');
      fill(runSelect, ...completeRuns.map((one) => h('option', { value: one.id }, runTitle(one))));
      const openRunId = store.get().review?.run?.id;
      if (openRunId && completeRuns.some(({ id }) => id === openRunId)) runSelect.value = openRunId;
      check();
    } catch (thrown) {
      if (!signal.aborted) setText(errorText, errorMessage(thrown));
    }
  }

  void load();
  if (data.file) fileField.set(data.file);
  check();
  return {
    title: `Import for ${video?.name ?? 'this video'}`,
    size: 'middle',
    submit,
    closed: () => data.back?.(imported),
    focus: fileField.button,
    body: h('div', form, mappingElement, resultElement),
    footer: [errorText, progress.element, backButton, h('button.btn', { onclick: close }, 'Close'), submitButton],
  };
}
