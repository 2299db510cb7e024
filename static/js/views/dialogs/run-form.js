// @ts-check
/** The form of a new run: preset, changed parameters and, for a single video, the range of frames. */

import { setModels } from '../../store/actions/page.js';
import { formatRunChoice, parseRunChoice } from '../../model/run_choice.js';
import { fill, h, setText } from '../dom.js';
import { plural } from '../../model/format.js';
import { icon } from '../icons.js';
import { createParameters, presetValue } from '../parameters.js';
import { recall, remember } from '../../core/preferences.js';

/** @typedef {import('../../api/runs.js').RunRequest} RunRequest */

/** The name under which the browser remembers the last choice. */
const LAST = 'run.last';

/**
 * @param {import('./layer.js').Setup} setup
 * @param {{frames: number|null, several: boolean, words: string, send: (order: RunRequest) => Promise<string>}} options
 * frames: of the video; several: the run is for several videos, so it has neither name nor range; words: text of the
 * button; send: starts the run, and returns an error in words
 */
export function createRunForm({ app, signal, close }, { frames, several, words, send }) {
  const { session, parameters } = app.store.get();
  const presets = session?.presets ?? ['default'];
  const last = parseRunChoice(recall(LAST), presets, parameters);
  const preset = h(
    'select.select',
    { id: 'run-preset', onchange: () => fields.rebase((parameter) => presetValue(parameter, preset.value)) },
    ...presets.map((name) => h('option', { value: name }, name)),
  );
  preset.value = last.preset;
  const name = h('input.input', { type: 'text', id: 'run-name', maxlength: 120, autocomplete: 'off', placeholder: 'optional' });
  const first = h('input.input', {
    type: 'text',
    inputmode: 'numeric',
    id: 'run-first',
    value: '0',
    autocomplete: 'off',
    'aria-describedby': 'run-range-error',
    oninput: check,
  });
  const end = h('input.input', {
    type: 'text',
    inputmode: 'numeric',
    id: 'run-last',
    autocomplete: 'off',
    placeholder: frames === null ? 'end' : String(frames - 1),
    'aria-describedby': 'run-range-error',
    oninput: check,
  });
  const rangeError = h('span.field-error', { id: 'run-range-error', role: 'alert' });
  const error = h('p.field-error.grow', { role: 'alert' });
  const start = h('button.btn.btn-primary', { type: 'submit' }, icon('run'), words);
  const summary = h('summary');
  const asLast = h(
    'p.field-hint.run-as-last',
    { hidden: Object.keys(last.parameters).length === 0 },
    'These changes are from the last run. ',
    h('button.btn.btn-small.btn-quiet', { onclick: () => fields.reset() }, 'Use the preset alone'),
  );
  const fields = createParameters({
    parameters,
    base: (parameter) => presetValue(parameter, preset.value),
    initial: last.parameters,
    onChange: told,
  });
  let sending = false;

  /** @param {number} changed   number of changed parameters */
  function told(changed) {
    setText(summary, changed ? `Parameters: ${plural(changed, 'change')}` : 'Parameters');
    if (changed === 0) asLast.hidden = true;
    check();
  }

  function range() {
    const from = first.value.trim() === '' ? 0 : Number(first.value);
    const to = end.value.trim() === '' ? null : Number(end.value);
    if (!Number.isInteger(from) || from < 0) return { error: 'The first frame must be a whole number from 0.' };
    if (to !== null && (!Number.isInteger(to) || to < from))
      return { error: `The last frame must be a whole number from ${from}, or empty for the end.` };
    if (frames !== null && Math.max(from, to ?? 0) >= frames) return { error: `The video has the frames 0 to ${frames - 1}.` };
    return { first: from, stop: to === null ? null : to + 1 };
  }

  function check() {
    const wrong = range().error ?? '';
    setText(rangeError, wrong);
    for (const input of [first, end]) input.setAttribute('aria-invalid', String(Boolean(wrong)));
    start.disabled = sending || Boolean(wrong) || fields.invalid() > 0;
  }

  async function submit() {
    const wanted = range();
    if (sending || wanted.error || fields.invalid()) return;
    sending = true;
    check();
    setText(error, '');
    const choice = { preset: preset.value, parameters: fields.changes() };
    remember(LAST, formatRunChoice(choice));
    const wrong = await send(several ? choice : { ...choice, first: wanted.first, stop: wanted.stop, name: name.value.trim() });
    sending = false;
    if (signal.aborted) return;
    setText(error, wrong);
    check();
  }

  const models = h('p.field-hint.run-models', 'Models: …');
  app
    .load(() => app.api.models({ signal }), setModels)
    .then(
      (found) => {
        fill(
          models,
          'Models: ',
          h('strong', found.find(({ active }) => active)?.name ?? 'Shipped'),
          ', ',
          h('a', { href: '#/models', onclick: close }, 'choose another'),
        );
      },
      () => {
        models.hidden = true; // the server chooses the models itself
      },
    );
  told(Object.keys(last.parameters).length);
  const element = h(
    'div.stack',
    h(
      'div.run-fields',
      h('div.field', h('label.field-label', { for: 'run-preset' }, 'Preset'), preset),
      ...(several
        ? []
        : [
            h('div.field', h('label.field-label', { for: 'run-name' }, 'Name'), name),
            h('div.field', h('label.field-label', { for: 'run-first' }, 'First frame'), first),
            h('div.field', h('label.field-label', { for: 'run-last' }, 'Last frame'), end),
          ]),
    ),
    rangeError,
    models,
    h('details.details', summary, asLast, fields.element),
  );
  return { element, submit, focus: preset, footer: [error, h('button.btn', { onclick: close }, 'Close'), start] };
}
