// @ts-check
/** Export: choose runs, content and format; then shows the progress of the file. */

import { ApiError, errorMessage } from '../../api/errors.js';
import { parseNumber, restoreChoice } from '../../model/exchange.js';
import { putOutput } from '../../store/actions/page.js';
import { createOutputRow } from '../output_row.js';
import { isActive } from '../output_text.js';
import { fill, h, setText } from '../dom.js';
import { icon } from '../icons.js';
import { count } from '../../model/format.js';
import { notifyWhenFinished } from '../output_notice.js';
import { recall, remember } from '../../core/preferences.js';
import { createExportEstimate } from './export_estimate.js';
import { createExportLabels } from './export_labels.js';
import { createExportRuns } from './export_runs.js';
import { createExportSplit } from './export_split.js';
import { choiceInput, field, group, messageWithField, numberInput, switchLabel, textInput } from './fields.js';
import { loadMissingRuns } from '../load_runs.js';

/** @typedef {import('../../types.js').Format} Format */
/** @typedef {import('../../types.js').Output} Output */
/** @typedef {import('../../types.js').ExportRequest} ExportRequest */

const STATES = /** @type {const} */ ([
  ['open', 'Open', 'Not reviewed or edited yet.'],
  ['edited', 'Edited', 'Open tracks that a person has drawn, moved, relabelled or split.'],
  ['accepted', 'Accepted', ''],
  ['needs_work', 'Needs work', ''],
  [
    'rejected',
    'False positives, separately',
    'Listed in the manifest as objects that look like a sign but are not: background for training.',
  ],
]);
const PICTURES = /** @type {const} */ ([
  ['none', 'None', 'Annotations only; the file stays small.'],
  ['annotated', 'Annotated frames', 'A picture of every frame that has a box.'],
  ['all', 'All frames', 'A picture of every frame.'],
]);

/**
 * The choices of pictures that a format allows.
 *
 * @param {import('../../types.js').Format|undefined} format
 * @returns {readonly (typeof PICTURES)[number][0][]}
 */
function picturesOf(format) {
  if (format?.needs_pictures) return ['annotated', 'all'];
  return format?.allows_pictures === false ? ['none'] : ['none', 'annotated', 'all'];
}

/** @type {import('./index.js').CreateDialog<'export'>} */
export function exportDialog({ app, data, close, signal }) {
  const { store, api } = app;
  const remembered = restoreChoice(recall('export'));
  // earlier choices do not restrict a selection made by hand
  const initial = data.tracks ? { ...remembered, states: STATES.map(([value]) => value), labels: null, min_side: '' } : remembered;
  /** @type {Format[]} */ let formats = [];
  const errorText = h('p.field-error.grow', { role: 'alert' });
  const submitButton = h('button.btn.btn-primary', { type: 'submit', disabled: true }, icon('export'), 'Export');
  const runs = createExportRuns(app, data.runs ?? [], check, signal);
  const counter = createExportEstimate(app, signal, (byLabel) => labels.show(byLabel));

  const states = STATES.map(([value, label, title]) =>
    choiceInput('checkbox', { value, title: title || undefined, checked: initial.states.includes(value), onchange: check }, label),
  );
  const labels = createExportLabels(store.get().labels, initial, check);
  const minSideInput = numberInput('export-side', initial.min_side, check, { placeholder: 'all sizes' });
  const firstInput = numberInput('export-first', '', check, { placeholder: '0', inputmode: 'numeric' });
  const lastInput = numberInput('export-last', '', check, { placeholder: 'end', inputmode: 'numeric' });
  const range = h('div.export-pair', field('First frame', firstInput), field('Last frame', lastInput));

  const formatSelect = h('select.select', { id: 'export-format', onchange: () => showFormat() });
  const summary = h('p.muted.small', { id: 'export-format-summary' });
  const switches = h('div.stack');
  /** As a person chose; the format may not allow it. */
  let chosenPictures = initial.pictures;
  const pictures = PICTURES.map(([value, label, title]) =>
    choiceInput('radio', { name: 'export-pictures', value, title, onchange: () => choosePictures(value) }, label),
  );
  const split = createExportSplit(initial, check);
  const maxErrorInput = numberInput('export-thin', initial.thin_px, check);
  const maxErrorField = field(
    'Maximum error between key frames, px',
    maxErrorInput,
    'Tracks get only as many key frames as linear interpolation needs to stay this close; 0 makes every frame a key frame.',
  );
  const nameInput = textInput('export-name', { maxlength: 120, placeholder: 'made from video and format' });
  const result = h('div.export-result', { 'aria-live': 'polite' });
  /** @type {{row: ReturnType<typeof createOutputRow>, id: string}|null} */ let createdFile = null;
  /** @type {Output|null} */ let shownOutput = null;
  const fileHint = h('span');

  const findSelectedFormat = () => formats.find((one) => one.name === formatSelect.value);

  function showFormat() {
    const selectedFormat = findSelectedFormat();
    setText(summary, selectedFormat?.summary ?? '');
    fill(
      switches,
      ...(selectedFormat?.export_switches ?? []).map((option) => {
        const control = h(
          'select.select',
          { id: `export-switch-${option.name}`, dataset: { name: option.name }, onchange: check },
          ...option.values.map((value) => h('option', { value }, value)),
        );
        const previous = initial.switches[selectedFormat?.name ?? '']?.[option.name];
        if (previous && option.values.includes(previous)) control.value = previous;
        return field(switchLabel(option.name), control, option.help);
      }),
    );
    check();
  }

  /** The request, or the first error in it. @returns {{request: ExportRequest}|{error: string}} */
  function read() {
    const selectedFormat = findSelectedFormat();
    if (!selectedFormat) return { error: '' };
    const runIds = runs.chosen();
    if (runIds.length === 0) return { error: 'Select at least one video.' };
    const chosenStates = /** @type {NonNullable<ExportRequest['states']>} */ (
      states.filter(({ input }) => input.checked).map(({ input }) => input.value)
    );
    if (chosenStates.length === 0) return { error: 'Select at least one review state.' };
    const labelKeys = labels.chosen();
    if (labelKeys?.length === 0 && labels.notInSet() === 'leave-out') return { error: 'Select at least one label.' };
    const frames = runs.frames();
    const lastFrame = frames === null ? 2 ** 31 - 2 : frames - 1;
    const numbers = {
      side: parseNumber(minSideInput.value, { name: 'The smallest side', low: 0, high: 10_000, empty: null }),
      first: parseNumber(firstInput.value, { name: 'The first frame', low: 0, high: lastFrame, whole: true, empty: 0 }),
      last: parseNumber(lastInput.value, { name: 'The last frame', low: 0, high: lastFrame, whole: true, empty: null }),
      thin: parseNumber(maxErrorInput.value, { name: 'The bound', low: 0, high: 100 }),
      ...split.numbers(),
    };
    /** @type {Record<string, number|null>} */ const values = {};
    for (const [key, found] of Object.entries(numbers)) {
      if (runIds.length > 1 && (key === 'first' || key === 'last')) continue;
      if (!selectedFormat.key_frames && key === 'thin') continue;
      if ('error' in found) return { error: found.error };
      values[key] = found.value;
    }
    if ((values.last ?? null) !== null && Number(values.last) < Number(values.first))
      return { error: 'The last frame comes before the first.' };
    if (split.isOn() && !values.train && !values.val && !values.test) return { error: 'Give at least one part of the split a share.' };
    return {
      request: {
        runs: runIds,
        format: selectedFormat.name,
        pictures: /** @type {ExportRequest['pictures']} */ (pictures.find(({ input }) => input.checked)?.input.value ?? 'none'),
        states: chosenStates,
        labels: labelKeys,
        not_in_set: labels.notInSet(),
        class_map: labels.classMap(),
        min_side: values.side,
        first: values.first ?? 0,
        stop: (values.last ?? null) === null ? null : Number(values.last) + 1,
        split: split.isOn() ? { train: values.train ?? 0, val: values.val ?? 0, test: values.test ?? 0 } : null,
        split_by: split.by(),
        balance_labels: split.isOn() && split.isBalanced(),
        split_seed: values.seed ?? 0,
        thin_px: values.thin ?? 0.5,
        switches: switchValues(),
        name: nameInput.value.trim(),
        ...(data.tracks ? { tracks: data.tracks } : {}),
      },
    };
  }

  /** @param {typeof initial.pictures} chosen */
  function choosePictures(chosen) {
    chosenPictures = chosen;
    check();
  }

  const switchValues = () =>
    Object.fromEntries([...switches.querySelectorAll('select')].map((control) => [control.dataset.name ?? '', control.value]));

  function check() {
    range.hidden = runs.chosen().length !== 1;
    split.show();
    const selectedFormat = findSelectedFormat();
    maxErrorField.hidden = selectedFormat?.key_frames !== true;
    labels.allowIgnore(selectedFormat?.ignores === true);
    const possiblePictures = picturesOf(selectedFormat);
    const shownPictures = possiblePictures.includes(chosenPictures) ? chosenPictures : possiblePictures[0];
    for (const { input } of pictures) {
      input.disabled = !possiblePictures.some((value) => value === input.value);
      input.checked = input.value === shownPictures;
    }
    const parsed = read();
    setText(errorText, 'error' in parsed ? parsed.error : '');
    submitButton.disabled = 'error' in parsed;
    // the count covers whole runs only
    counter.show('request' in parsed && !data.tracks ? parsed.request : null);
  }

  async function submit() {
    const parsed = read();
    if ('error' in parsed) return;
    submitButton.disabled = true;
    if (!data.tracks)
      remember(
        'export',
        JSON.stringify({
          format: parsed.request.format,
          pictures: chosenPictures,
          states: parsed.request.states,
          labels: parsed.request.labels,
          not_in_set: parsed.request.not_in_set,
          class_map: parsed.request.class_map,
          min_side: minSideInput.value,
          ...split.choice(),
          thin_px: maxErrorInput.value,
          switches: { ...initial.switches, [parsed.request.format]: parsed.request.switches },
        }),
      );
    try {
      const output = await app.load(() => api.startExport(parsed.request, { signal }), putOutput);
      const row = createOutputRow(app, output);
      createdFile = { row, id: output.id };
      show(output);
      fill(
        result,
        h('h3', 'The export'),
        h('ul.made-list', row.element),
        h('p.muted.small', fileHint, h('a', { href: '#/files', onclick: close }, 'Files'), '.'),
      );
      result.scrollIntoView({ block: 'nearest' });
      void follow(output);
    } catch (thrown) {
      if (signal.aborted) return;
      setText(errorText, messageWithField(thrown));
    } finally {
      submitButton.disabled = false;
    }
  }

  /** @param {Output} output */
  function show(output) {
    shownOutput = output;
    createdFile?.row.show(output);
    setText(fileHint, isActive(output) ? 'You can close this dialog. The export continues and is listed under ' : 'It is listed under ');
  }

  /** Poll the export: the event stream is faster, but may be down. @param {Output} output */
  async function follow(output) {
    while (isActive(output) && createdFile?.id === output.id) {
      await new Promise((resolve) => setTimeout(resolve, 1500));
      if (signal.aborted) return;
      try {
        const { id } = output;
        output = await app.load(() => api.output(id, { signal }), putOutput);
        if (store.get().outputs === null) show(output);
      } catch (thrown) {
        if (signal.aborted || (thrown instanceof ApiError && thrown.status === 404)) return;
      }
    }
  }

  async function load() {
    try {
      formats = (await api.formats({ signal })).filter(({ can_export }) => can_export);
      fill(formatSelect, ...formats.map((one) => h('option', { value: one.name }, one.title)));
      formatSelect.value = initial.format;
      if (formatSelect.selectedIndex < 0) formatSelect.selectedIndex = 0;
      showFormat();
    } catch (thrown) {
      if (!signal.aborted) setText(errorText, errorMessage(thrown));
    }
    for (const video of store.get().videos ?? []) {
      if (signal.aborted) return;
      if (video.runs > 0) await loadMissingRuns(app, video.id, { signal }).catch(() => null);
    }
  }

  signal.addEventListener(
    'abort',
    () => {
      if (shownOutput && isActive(shownOutput)) notifyWhenFinished(app, shownOutput.id);
    },
    { once: true },
  );
  void load();
  return {
    title: 'Export annotations',
    size: 'wide',
    submit,
    focus: formatSelect,
    body: h(
      'div.stack',
      h(
        'div.run-dialog',
        h(
          'section.run-column',
          { 'aria-labelledby': 'export-what' },
          h('h3', { id: 'export-what' }, 'Data'),
          data.tracks
            ? h('p.field-warning', `Only the ${count(Object.values(data.tracks).flat().length)} selected tracks are exported.`)
            : null,
          runs.element,
          group('Review states', h('div.ticks', ...states.map(({ element }) => element))),
          labels.element,
          field('Smallest shorter side, px', minSideInput),
          range,
        ),
        h(
          'section.run-column',
          { 'aria-labelledby': 'export-how' },
          h('h3', { id: 'export-how' }, 'Format options'),
          h('div.stack', field('Format', formatSelect), summary),
          switches,
          group('Pictures', h('div.ticks', ...pictures.map(({ element }) => element))),
          split.element,
          maxErrorField,
          field('File name', nameInput),
        ),
      ),
      result,
    ),
    footer: [counter.element, errorText, h('button.btn', { onclick: close }, 'Close'), submitButton],
    update(state) {
      runs.update(state);
      const now = createdFile && state.outputs?.find(({ id }) => id === createdFile?.id);
      if (createdFile && now && now !== shownOutput) show(now);
    },
  };
}
