// @ts-check
/** The form of a new run: preset, changed parameters and, for a single video, the range of frames. */

import { setModels } from '../../store/actions/page.js';
import { formatRunChoice, parseRunChoice } from '../../model/run_choice.js';
import { fill, h, selectInput, setText } from '../dom.js';
import { plural } from '../../model/format.js';
import { icon } from '../icons.js';
import { createParameterFields, presetValue } from '../parameter_fields.js';
import { recall, remember } from '../../core/preferences.js';
import { field, numberInput, textInput } from './fields.js';

/** @typedef {import('../../api/runs.js').RunRequest} RunRequest */

/** The name under which the browser remembers the last choice. */
const STORAGE_KEY = 'run.last';

/**
 * @param {import('./index.js').DialogSetup} setup
 * @param {{frames: number|null, several: boolean, buttonText: string, send: (order: RunRequest) => Promise<string>}} options
 * frames: of the video; several: the run is for several videos, so it has neither name nor range; buttonText: text of the
 * button; send: starts the run, and returns an error in words
 */
export function createRunForm({ app, signal, close }, { frames, several, buttonText, send }) {
  const { session, parameters } = app.store.get();
  const presets = session?.presets ?? ['default'];
  const lastChoice = parseRunChoice(recall(STORAGE_KEY), presets, parameters);
  const presetSelect = selectInput(
    { id: 'run-preset', onchange: () => parameterFields.rebase((parameter) => presetValue(parameter, presetSelect.value)) },
    presets.map((name) => [name, name]),
    lastChoice.preset,
  );
  const nameInput = textInput('run-name', { maxlength: 120, placeholder: 'optional' });
  const rangeProps = { inputmode: 'numeric', 'aria-describedby': 'run-range-error' };
  const firstInput = numberInput('run-first', '0', check, rangeProps);
  const lastInput = numberInput('run-last', '', check, { ...rangeProps, placeholder: frames === null ? 'end' : String(frames - 1) });
  const rangeError = h('span.field-error', { id: 'run-range-error', role: 'alert' });
  const errorText = h('p.field-error.grow', { role: 'alert' });
  const startButton = h('button.btn.btn-primary', { type: 'submit' }, icon('run'), buttonText);
  const summaryElement = h('summary');
  const lastChangesHint = h(
    'p.field-hint.run-as-last',
    { hidden: Object.keys(lastChoice.parameters).length === 0 },
    'These changes are from the last run. ',
    h('button.btn.btn-small.btn-quiet', { onclick: () => parameterFields.reset() }, 'Use the preset alone'),
  );
  const parameterFields = createParameterFields({
    parameters,
    base: (parameter) => presetValue(parameter, presetSelect.value),
    initial: lastChoice.parameters,
    onChange: onParametersChange,
  });
  let isSending = false;

  /** @param {number} changed   number of changed parameters */
  function onParametersChange(changed) {
    setText(summaryElement, changed ? `Parameters: ${plural(changed, 'change')}` : 'Parameters');
    if (changed === 0) lastChangesHint.hidden = true;
    check();
  }

  function readRange() {
    const firstFrame = firstInput.value.trim() === '' ? 0 : Number(firstInput.value);
    const lastFrame = lastInput.value.trim() === '' ? null : Number(lastInput.value);
    if (!Number.isInteger(firstFrame) || firstFrame < 0) return { error: 'The first frame must be a whole number from 0.' };
    if (lastFrame !== null && (!Number.isInteger(lastFrame) || lastFrame < firstFrame))
      return { error: `The last frame must be a whole number from ${firstFrame}, or empty for the end.` };
    if (frames !== null && Math.max(firstFrame, lastFrame ?? 0) >= frames) return { error: `The video has the frames 0 to ${frames - 1}.` };
    return { first: firstFrame, stop: lastFrame === null ? null : lastFrame + 1 };
  }

  function check() {
    const problem = readRange().error ?? '';
    setText(rangeError, problem);
    for (const input of [firstInput, lastInput]) input.setAttribute('aria-invalid', String(Boolean(problem)));
    startButton.disabled = isSending || Boolean(problem) || parameterFields.invalid() > 0;
  }

  async function submit() {
    const range = readRange();
    if (isSending || range.error || parameterFields.invalid()) return;
    isSending = true;
    check();
    setText(errorText, '');
    const choice = { preset: presetSelect.value, parameters: parameterFields.changes() };
    remember(STORAGE_KEY, formatRunChoice(choice));
    const problem = await send(several ? choice : { ...choice, first: range.first, stop: range.stop, name: nameInput.value.trim() });
    isSending = false;
    if (signal.aborted) return;
    setText(errorText, problem);
    check();
  }

  const models = h('p.field-hint.run-models', 'Models: …');
  app
    .load(() => app.api.models({ signal }), setModels)
    .then(
      (versions) => {
        fill(
          models,
          'Models: ',
          h('strong', versions.find(({ active }) => active)?.name ?? 'Shipped'),
          ', ',
          h('a', { href: '#/models', onclick: close }, 'choose another'),
        );
      },
      () => {
        models.hidden = true; // the server chooses the models itself
      },
    );
  onParametersChange(Object.keys(lastChoice.parameters).length);
  const element = h(
    'div.stack',
    h(
      'div.run-fields',
      field('Preset', presetSelect),
      ...(several ? [] : [field('Name', nameInput), field('First frame', firstInput), field('Last frame', lastInput)]),
    ),
    rangeError,
    models,
    h('details.details', summaryElement, lastChangesHint, parameterFields.element),
  );
  return { element, submit, focus: presetSelect, footer: [errorText, h('button.btn', { onclick: close }, 'Close'), startButton] };
}
