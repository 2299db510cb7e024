// @ts-check
/** Export: choose runs, content and format; then shows the progress of the file. */

import { ApiError, sentence } from '../../api/errors.js';
import { parseNumber, restoreChoice } from '../../model/exchange.js';
import { putOutput, setRuns } from '../../store/actions/page.js';
import { createOutputRow } from '../output-row.js';
import { isActive } from '../output-words.js';
import { fill, h, setText } from '../dom.js';
import { icon } from '../icons.js';
import { count } from '../../model/format.js';
import { tellWhenMade } from '../made_notice.js';
import { recall, remember } from '../../core/preferences.js';
import { createExportCount } from './export-count.js';
import { createExportLabels } from './export-labels.js';
import { createExportRuns } from './export-runs.js';
import { createExportSplit } from './export-split.js';
import { field, group, numberInput, tick } from './fields.js';

/** @typedef {import('../../types.js').Format} Format */
/** @typedef {import('../../types.js').Output} Output */
/** @typedef {import('../../types.js').ExportRequest} ExportRequest */

const STATES = /** @type {const} */ ([
  ['open', 'Open', 'Not judged or edited yet.'],
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
 * @param {import('./layer.js').Setup<'export'>} setup
 * @returns {import('./layer.js').Content}
 */
export function exportDialog({ app, data, close, signal }) {
  const { store, api } = app;
  const usual = restoreChoice(recall('export'));
  // earlier choices do not restrict a selection made by hand
  const kept = data.tracks ? { ...usual, states: STATES.map(([value]) => value), labels: null, min_side: '' } : usual;
  /** @type {Format[]} */
  let formats = [];
  const error = h('p.field-error.grow', { role: 'alert' });
  const go = h('button.btn.btn-primary', { type: 'submit', disabled: true }, icon('export'), 'Export');
  const runs = createExportRuns(app, data.runs ?? [], check, signal);
  const counter = createExportCount(app, signal, (byLabel) => labels.show(byLabel));

  const states = STATES.map(([value, label, title]) =>
    tick('checkbox', { value, title: title || undefined, checked: kept.states.includes(value), onchange: check }, label),
  );
  const labels = createExportLabels(store.get().labels, kept, check);
  const side = numberInput('export-side', kept.min_side, check, { placeholder: 'all sizes' });
  const first = numberInput('export-first', '', check, { placeholder: '0', inputmode: 'numeric' });
  const last = numberInput('export-last', '', check, { placeholder: 'end', inputmode: 'numeric' });
  const range = h('div.export-pair', field('First frame', first), field('Last frame', last));

  const format = h('select.select', { id: 'export-format', onchange: () => showFormat() });
  const summary = h('p.muted.small', { id: 'export-format-summary' });
  const switches = h('div.stack');
  const pictures = PICTURES.map(([value, label, title]) =>
    tick('radio', { name: 'export-pictures', value, title, checked: kept.pictures === value, onchange: check }, label),
  );
  const split = createExportSplit(kept, check);
  const thin = numberInput('export-thin', kept.thin_px, check);
  const thinField = field(
    'Maximum error between key frames, px',
    thin,
    'Tracks get only as many key frames as linear interpolation needs to stay this close; 0 makes every frame a key frame.',
  );
  const name = h('input.input', {
    type: 'text',
    id: 'export-name',
    maxlength: 120,
    autocomplete: 'off',
    placeholder: 'made from video and format',
  });
  const result = h('div.export-result', { 'aria-live': 'polite' });
  /** @type {{row: ReturnType<typeof createOutputRow>, id: string}|null} */
  let made = null;
  /** @type {Output|null} */
  let shownMade = null;

  const chosenFormat = () => formats.find((one) => one.name === format.value);

  function showFormat() {
    const chosen = chosenFormat();
    setText(summary, chosen?.summary ?? '');
    fill(
      switches,
      ...(chosen?.export_switches ?? []).map((option) => {
        const control = h(
          'select.select',
          { id: `export-switch-${option.name}`, dataset: { name: option.name }, onchange: check },
          ...option.values.map((value) => h('option', { value }, value)),
        );
        const before = kept.switches[chosen?.name ?? '']?.[option.name];
        if (before && option.values.includes(before)) control.value = before;
        return field(plain(option.name), control, option.help);
      }),
    );
    check();
  }

  /** The request, or the first error in it. @returns {{request: ExportRequest}|{error: string}} */
  function read() {
    const chosen = chosenFormat();
    if (!chosen) return { error: '' };
    const ids = runs.chosen();
    if (ids.length === 0) return { error: 'Select at least one video.' };
    const wanted = /** @type {NonNullable<ExportRequest['states']>} */ (
      states.filter(({ input }) => input.checked).map(({ input }) => input.value)
    );
    if (wanted.length === 0) return { error: 'Select at least one review state.' };
    const picked = labels.chosen();
    if (picked?.length === 0 && labels.notInSet() === 'leave-out') return { error: 'Select at least one label.' };
    const frames = runs.frames();
    const most = frames === null ? 2 ** 31 - 2 : frames - 1;
    const numbers = {
      side: parseNumber(side.value, { name: 'The smallest side', low: 0, high: 10_000, empty: null }),
      first: parseNumber(first.value, { name: 'The first frame', low: 0, high: most, whole: true, empty: 0 }),
      last: parseNumber(last.value, { name: 'The last frame', low: 0, high: most, whole: true, empty: null }),
      thin: parseNumber(thin.value, { name: 'The bound', low: 0, high: 100 }),
      ...split.numbers(),
    };
    /** @type {Record<string, number|null>} */
    const values = {};
    for (const [key, found] of Object.entries(numbers)) {
      if (ids.length > 1 && (key === 'first' || key === 'last')) continue;
      if (!chosen.key_frames && key === 'thin') continue;
      if ('error' in found) return { error: found.error };
      values[key] = found.value;
    }
    if ((values.last ?? null) !== null && Number(values.last) < Number(values.first))
      return { error: 'The last frame comes before the first.' };
    if (split.isOn() && !values.train && !values.val && !values.test) return { error: 'Give at least one part of the split a share.' };
    return {
      request: {
        runs: ids,
        format: chosen.name,
        pictures: /** @type {ExportRequest['pictures']} */ (pictures.find(({ input }) => input.checked)?.input.value ?? 'none'),
        states: wanted,
        labels: picked,
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
        name: name.value.trim(),
        ...(data.tracks ? { tracks: data.tracks } : {}),
      },
    };
  }

  const switchValues = () =>
    Object.fromEntries([...switches.querySelectorAll('select')].map((control) => [control.dataset.name ?? '', control.value]));

  function check() {
    range.hidden = runs.chosen().length !== 1;
    split.show();
    const chosen = chosenFormat();
    thinField.hidden = chosen?.key_frames !== true;
    labels.allowIgnore(chosen?.ignores === true);
    const none = pictures[0].input;
    none.disabled = chosen?.needs_pictures === true;
    if (none.disabled && none.checked) pictures[1].input.checked = true;
    const found = read();
    setText(error, 'error' in found ? found.error : '');
    go.disabled = 'error' in found;
    // the count covers whole runs only
    counter.show('request' in found && !data.tracks ? found.request : null);
  }

  async function submit() {
    const found = read();
    if ('error' in found) return;
    go.disabled = true;
    if (!data.tracks)
      remember(
        'export',
        JSON.stringify({
          format: found.request.format,
          pictures: found.request.pictures,
          states: found.request.states,
          labels: found.request.labels,
          not_in_set: found.request.not_in_set,
          class_map: found.request.class_map,
          min_side: side.value,
          ...split.choice(),
          thin_px: thin.value,
          switches: { ...kept.switches, [found.request.format]: found.request.switches },
        }),
      );
    try {
      const output = await app.load(() => api.startExport(found.request, { signal }), putOutput);
      const row = createOutputRow(app, output);
      made = { row, id: output.id };
      shownMade = output;
      fill(
        result,
        h('h3', 'The export'),
        h('ul.made-list', row.element),
        h(
          'p.muted.small',
          'You can close this dialog. The export continues and is listed under ',
          h('a', { href: '#/files', onclick: close }, 'Files'),
          '.',
        ),
      );
      result.scrollIntoView({ block: 'nearest' });
      void follow(output);
    } catch (thrown) {
      if (signal.aborted) return;
      const where = thrown instanceof ApiError && thrown.field ? `${thrown.field}: ` : '';
      setText(error, sentence(thrown).startsWith(where) ? sentence(thrown) : where + sentence(thrown));
    } finally {
      go.disabled = false;
    }
  }

  /** Poll the export: the event stream is faster, but may be down. @param {Output} now */
  async function follow(now) {
    while (isActive(now) && made?.id === now.id) {
      await new Promise((resolve) => setTimeout(resolve, 1500));
      if (signal.aborted) return;
      try {
        const { id } = now;
        now = await app.load(() => api.output(id, { signal }), putOutput);
        if (store.get().outputs === null) made?.row.show(now);
      } catch (thrown) {
        if (signal.aborted || (thrown instanceof ApiError && thrown.status === 404)) return;
      }
    }
  }

  async function load() {
    try {
      formats = (await api.formats({ signal })).filter(({ can_export }) => can_export);
      fill(format, ...formats.map((one) => h('option', { value: one.name }, one.title)));
      format.value = kept.format;
      if (format.selectedIndex < 0) format.selectedIndex = 0;
      showFormat();
    } catch (thrown) {
      if (!signal.aborted) setText(error, sentence(thrown));
    }
    for (const video of store.get().videos ?? []) {
      if (signal.aborted) return;
      if (store.get().runs[video.id] || video.runs === 0) continue;
      await app
        .load(
          () => api.runs(video.id, { signal }),
          (state, runs) => setRuns(state, video.id, runs),
        )
        .catch(() => null);
    }
  }

  signal.addEventListener(
    'abort',
    () => {
      if (shownMade && isActive(shownMade)) tellWhenMade(app, shownMade.id);
    },
    { once: true },
  );
  void load();
  return {
    title: 'Export annotations',
    size: 'wide',
    submit,
    focus: format,
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
          field('Smallest shorter side, px', side),
          range,
        ),
        h(
          'section.run-column',
          { 'aria-labelledby': 'export-how' },
          h('h3', { id: 'export-how' }, 'Format options'),
          h('div.stack', field('Format', format), summary),
          switches,
          group('Pictures', h('div.ticks', ...pictures.map(({ element }) => element))),
          split.element,
          thinField,
          field('File name', name),
        ),
      ),
      result,
    ),
    footer: [counter.element, error, h('button.btn', { onclick: close }, 'Close'), go],
    update(state) {
      runs.update(state);
      const now = made && state.outputs?.find(({ id }) => id === made?.id);
      if (made && now && now !== shownMade) {
        shownMade = now;
        made.row.show(now);
      }
    },
  };
}

/** @param {string} name */
const plain = (name) => name.charAt(0).toUpperCase() + name.slice(1).replaceAll(/[_-]/g, ' ');
