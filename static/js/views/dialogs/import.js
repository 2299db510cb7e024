// @ts-check
/** Import a file of another tool onto a video: as corrections, as ground truth or as a run. */

import { ApiError, sentence } from '../../api/errors.js';
import { parseLabelMap } from '../../model/label_mapping.js';
import { formatRoute } from '../../model/route.js';
import { putRun, setRuns } from '../../store/actions/page.js';
import { skippedItems } from '../output-row.js';
import { fill, h, setText } from '../dom.js';
import { bytes, count, plural } from '../../model/format.js';
import { icon } from '../icons.js';
import { openOver } from '../open-over.js';
import { recall, remember, authorName } from '../../core/preferences.js';
import { runTitle } from '../../model/describe_run.js';
import { toast } from '../../core/toast.js';
import { createDropField } from './drop-field.js';
import { field, group, tick } from './fields.js';
import { createMapping } from './import-labels.js';
import { createImportProgress } from './import-progress.js';

/** @typedef {import('../../types.js').Format} Format */
/** @typedef {import('../../types.js').ImportResult} ImportResult */

const KINDS = /** @type {const} */ ([
  ['annotation', 'Corrections', 'Merged into a run, track by track. One undo reverts all of it.'],
  ['truth', 'Ground truth', 'A separate layer that runs are compared with.'],
  ['run', 'Run', 'Somebody else’s detector or tracker, shown and compared like a run of the engine.'],
]);

const SHOW = { annotation: 'Show the corrected run', truth: 'Show the ground truth', run: 'Show the run' };

/**
 * @param {import('./layer.js').Setup<'import'>} setup
 * @returns {import('./layer.js').Content}
 */
export function importDialog({ app, data, close, signal }) {
  const { store, api } = app;
  const video = store.get().videos?.find(({ id }) => id === data.video) ?? store.get().review?.video;
  /** @type {Format[]} */
  let formats = [];
  const error = h('p.field-error.grow', { role: 'alert' });
  const refused = h('div.import-refused', { role: 'alert', hidden: true });
  const progress = createImportProgress({ api });
  const go = h('button.btn.btn-primary', { type: 'submit', disabled: true }, icon('add'), 'Import');
  const drop = createDropField({
    id: 'import-file',
    label: 'File',
    hint: 'XML, JSON, CSV, TXT, or a ZIP that contains all files. You can also drop it here.',
    onChange: () => {
      if (!name.dataset.typed)
        name.value =
          drop
            .file()
            ?.name.replace(/\.(zip|xml|json|csv|txt|jsonl)$/i, '')
            .slice(0, 120) ?? '';
      refused.hidden = true;
      check();
    },
  });
  const wanted = data.as ?? recall('import.as') ?? 'truth';
  const kinds = KINDS.map(([value, label, title]) =>
    tick(
      'radio',
      { name: 'import-as', value, checked: value === wanted, onchange: check },
      h('span.kind-name', label),
      h('span.muted.small', title),
    ),
  );
  const run = h('select.select', { id: 'import-run', onchange: check });
  const runField = field('Run to correct', run);
  const name = h('input.input', {
    type: 'text',
    id: 'import-name',
    maxlength: 120,
    autocomplete: 'off',
    oninput: () => {
      name.dataset.typed = 'yes';
      check();
    },
  });
  const nameField = field('Name', name, 'A ground truth of the same name is replaced.');
  const format = h(
    'select.select',
    { id: 'import-format', onchange: () => showFormat() },
    h('option', { value: '' }, 'detected from the file'),
  );
  const summary = h('p.muted.small');
  const switches = h('div.stack');
  const names = h('textarea.textarea', {
    id: 'import-names',
    rows: 3,
    spellcheck: 'false',
    placeholder: 'stop sign = stop',
    oninput: check,
  });
  const result = h('div.stack', { hidden: true });
  /** @type {ImportResult|null} */ let imported = null;
  /** The labels of the video’s set. @type {readonly import('../../types.js').Label[]} */
  let labels = store.get().labels;
  /** The names that must be mapped first. @type {ReturnType<typeof createMapping>|null} */
  let mapping = null;
  const mapped = h('div.stack', { hidden: true });
  const back = h('button.btn', { hidden: true, onclick: () => askNames(null) }, 'Back');
  const form = h(
    'div.stack',
    drop.element,
    group('Import as', h('div.kinds', ...kinds.map(({ element }) => element))),
    h('div.run-fields', runField, nameField, h('div.stack', field('Format', format), summary)),
    switches,
    h(
      'details.details',
      h('summary', 'Names of the file'),
      field(
        'One per line: name = label',
        names,
        'For names without a matching label, the dialog asks with examples before anything is stored.',
      ),
    ),
    refused,
  );

  const kind = () => kinds.find(({ input }) => input.checked)?.input.value ?? 'truth';
  /** @returns {'annotation'|'truth'|'run'} */
  const as = () => /** @type {'annotation'|'truth'|'run'} */ (kind());

  function showFormat() {
    const chosen = formats.find((one) => one.name === format.value);
    setText(summary, chosen?.summary ?? '');
    fill(
      switches,
      ...(chosen?.import_switches ?? []).map((option) =>
        field(`${option.name.charAt(0).toUpperCase()}${option.name.slice(1).replaceAll('_', ' ')}`, controlOf(option), option.help),
      ),
    );
    check();
  }

  /** @param {import('../../types.js').Switch} option */
  function controlOf({ name, values, free }) {
    const given = { id: `import-switch-${name}`, dataset: { name } };
    return free
      ? h('input.input', { ...given, type: 'text', value: values[0], autocomplete: 'off' })
      : h('select.select', { ...given }, ...values.map((value) => h('option', { value }, value)));
  }

  function problem() {
    const file = drop.file();
    const most = store.get().session?.upload_bytes;
    if (!file) return 'Choose a file.';
    if (most !== undefined && file.size > most) return `The file has ${bytes(file.size)}; at most ${bytes(most)} are allowed.`;
    if (as() === 'annotation' && !run.value) return 'There is no complete run to correct yet.';
    if (as() !== 'annotation' && !name.value.trim()) return 'Give it a name.';
    const map = parseLabelMap(names.value, labels);
    if ('error' in map) return map.error;
    const answers = mapping?.read();
    return answers && 'error' in answers ? answers.error : '';
  }

  function check() {
    runField.hidden = as() !== 'annotation';
    nameField.hidden = as() === 'annotation';
    const wrong = problem();
    go.disabled = wrong !== '';
    setText(error, drop.file() ? wrong : '');
  }

  async function submit() {
    const file = drop.file();
    const map = parseLabelMap(names.value, labels);
    const answers = mapping?.read() ?? { map: {}, add: [], skip: [] };
    if (!file || problem() !== '' || 'error' in map || 'error' in answers) return;
    go.disabled = true;
    refused.hidden = true;
    remember('import.as', kind());
    const controls = /** @type {NodeListOf<HTMLInputElement|HTMLSelectElement>} */ (switches.querySelectorAll('select, input'));
    const values = Object.fromEntries(
      [...controls].filter(({ value }) => value.trim() !== '').map((control) => [control.dataset.name ?? '', control.value.trim()]),
    );
    try {
      const unknown = answers.skip.length ? 'skip' : answers.add.length ? 'add' : 'refuse';
      const found = await progress.during(signal, ({ progress: called, sending }) =>
        api.importFile(
          data.video,
          file,
          {
            progress: called,
            as: as(),
            format: format.value || null,
            run: as() === 'annotation' ? run.value : null,
            name: as() === 'annotation' ? file.name.replaceAll('/', '_').slice(0, 120) : name.value.trim(),
            switches: JSON.stringify(values),
            label_map: JSON.stringify({ ...map.map, ...answers.map }),
            unknown,
            add: JSON.stringify(answers.add),
            author: authorName(app.store.get().session),
          },
          sending,
        ),
      );
      setText(error, '');
      if (answers.add.length) await app.labels.reload();
      await show(found);
    } catch (thrown) {
      if (signal.aborted) return;
      setText(error, '');
      if (thrown instanceof ApiError && thrown.code === 'unknown_labels' && Array.isArray(thrown.details.labels)) {
        askNames(thrown.details.labels);
        return;
      }
      go.disabled = false;
      if (mapping !== null) {
        setText(error, sentence(thrown));
        return;
      }
      refused.hidden = false;
      fill(
        refused,
        icon('alert'),
        h(
          'div.stack',
          h(
            'strong',
            { bad_file: 'The file breaks a rule', cancelled: 'Cancelled' }[thrown instanceof ApiError ? thrown.code : ''] ??
              'The import failed',
          ),
          h('p', sentence(thrown)),
        ),
      );
      refused.scrollIntoView({ block: 'nearest' });
    }
  }

  /** Ask how to map names; null: show the form again. @param {import('../../types.js').UnknownLabel[]|null} unknown */
  function askNames(unknown) {
    mapping = unknown && createMapping({ api, video: data.video, unknown, labels, changed: check, signal });
    fill(mapped, mapping?.element);
    form.hidden = mapping !== null;
    mapped.hidden = back.hidden = mapping === null;
    check();
    /** @type {HTMLElement|null} */ (mapped.querySelector('select'))?.focus();
  }

  /** @param {ImportResult} found */
  async function show(found) {
    imported = found;
    if (found.kind === 'run') {
      await app.load(() => api.run(found.id, { signal }), putRun);
    } else if (found.kind === 'annotation') {
      if (store.get().review?.run?.id === found.id) await app.editor.refresh();
    } else if (store.get().review?.video.id === data.video) {
      app.loader.showTruth(found.id);
    }
    const words = [
      `${plural(found.tracks, 'track')} with ${plural(found.boxes, 'box', 'boxes')}`,
      found.same ? `${plural(found.same, 'further track')} the same as before` : '',
    ]
      .filter(Boolean)
      .join('; ');
    if (data.back && found.repaired.length + found.skipped.length === 0) {
      toast(`Imported: ${words}.`, { tone: 'good' });
      close();
      return;
    }
    form.hidden = mapped.hidden = back.hidden = true;
    result.hidden = false;
    go.hidden = true;
    fill(
      result,
      h('p.import-done', { role: 'status' }, icon('check'), h('strong', `Imported: ${words}.`)),
      found.repaired.length > 0 &&
        h(
          'section.stack',
          h('h3', `Repaired (${count(found.repaired.length)})`),
          h('ul.skipped-list.small', ...found.repaired.map((text) => h('li', text))),
        ),
      found.skipped.length > 0 &&
        h(
          'section.stack',
          h('h3', `Skipped (${count(found.skipped.length)})`),
          h('ul.skipped-list.small', ...skippedItems(found.skipped, found.skipped.length)),
        ),
      h(
        'div.row',
        h(
          'button.btn.btn-primary',
          { onclick: () => (data.back ? close() : open(found)) },
          icon('eye'),
          data.back ? 'Back to the comparison' : SHOW[found.kind],
        ),
      ),
    );
    result.querySelector('button')?.focus();
  }

  /** @param {ImportResult} found */
  function open(found) {
    const { review } = store.get();
    close();
    const here = review?.video.id === data.video;
    if (found.kind === 'truth') {
      if (here) return;
      location.hash = formatRoute({ screen: 'review', video: data.video, run: null, frame: null, track: null });
      openOver(app, null, { truth: found.id, video: data.video });
      return;
    }
    location.hash = formatRoute({
      screen: 'review',
      video: data.video,
      run: found.id,
      frame: here && review ? review.frame : null,
      track: null,
    });
  }

  async function load() {
    try {
      const [known, own, runs] = await Promise.all([
        api.formats({ signal }),
        api.labels(video?.label_set ? video.id : null, { signal }),
        app.load(
          () => api.runs(data.video, { signal }),
          (state, found) => setRuns(state, data.video, found),
        ),
      ]);
      labels = own;
      formats = known.filter(({ can_import }) => can_import);
      format.append(...formats.map((one) => h('option', { value: one.name }, one.title)));
      const usable = runs.filter(({ state }) => state === 'complete');
      fill(run, ...usable.map((one) => h('option', { value: one.id }, runTitle(one))));
      const present = store.get().review?.run?.id;
      if (present && usable.some(({ id }) => id === present)) run.value = present;
      check();
    } catch (thrown) {
      if (!signal.aborted) setText(error, sentence(thrown));
    }
  }

  void load();
  if (data.file) drop.set(data.file);
  check();
  return {
    title: `Import for ${video?.name ?? 'this video'}`,
    size: 'middle',
    submit,
    closed: () => data.back?.(imported),
    focus: drop.button,
    body: h('div', form, mapped, result),
    footer: [error, progress.element, back, h('button.btn', { onclick: close }, 'Close'), go],
  };
}
