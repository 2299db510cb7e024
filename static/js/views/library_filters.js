// @ts-check
/** Filters of the library: videos with a track of a label, an attribute value and a review state. */

import { errorMessage } from '../api/errors.js';
import { answerText, attributeChoices } from '../model/attributes.js';
import { NO_CLASS } from '../model/documents.js';
import { labelFinder } from '../model/label_finder.js';
import { offeredLabels } from '../model/labels.js';
import { fill, h, selectInput, setText } from './dom.js';
import { plural } from '../model/format.js';

/** @typedef {{label: string, attribute: string, value: string, state: string}} LibraryFilters   as typed; empty: any */

/** @type {LibraryFilters} */
export const NO_FILTERS = Object.freeze({ label: '', attribute: '', value: '', state: '' });
const NOT_IN_SET = 'Not in the set';
const STATES = /** @type {const} */ ([
  ['', 'Any state'],
  ['open', 'Open'],
  ['needs_work', 'Needs work'],
  ['accepted', 'Accepted'],
  ['rejected', 'False positive'],
  ['ignored', 'Ignored'],
]);
/** Pause in typing before a request, ms. */
const TYPING_DELAY_MS = 250;
/** Delay of a new request after a change of the library, ms. */
const REFRESH_DELAY_MS = 1000;

/**
 * The query for the server; null: no filter is set.
 *
 * @param {LibraryFilters} chosen
 * @param {readonly import('../types.js').Label[]} labels
 * @returns {{label?: string, attribute?: string, value?: string, state?: string}|{error: string}|null}
 */
export function matchQuery({ label, attribute, value, state }, labels) {
  const typed = label.trim();
  const isNotInSet = typed.toLowerCase() === NOT_IN_SET.toLowerCase();
  const found = typed && !isNotInSet ? labelFinder(labels).find(typed) : null;
  if (typed && !isNotInSet && (found === null || (found.how === 'number' && !typed.startsWith('#'))))
    return { error: `No label is called “${typed.slice(0, 60)}”.` };
  const query = {
    ...(typed && { label: isNotInSet ? String(NO_CLASS) : (found?.label.key ?? '') }),
    ...(attribute && { attribute, ...(value.trim() && { value: value.trim() }) }),
    ...(state && { state }),
  };
  return Object.keys(query).length ? query : null;
}

/**
 * @param {import('../page-types.js').App} app
 * @param {{initialFilters: LibraryFilters, onChange: (filters: LibraryFilters) => void, signal: AbortSignal}} options   onChange: called when the matching videos change
 */
export function createLibraryFilters(app, { initialFilters, onChange, signal }) {
  const labelOptions = h('datalist', { id: 'library-labels' });
  const label = h('input.input', {
    type: 'search',
    list: 'library-labels',
    placeholder: 'Any label',
    autocomplete: 'off',
    dir: 'auto',
    'aria-label': 'Videos with the label',
    value: initialFilters.label,
    oninput: () => scheduleRequest(TYPING_DELAY_MS),
  });
  const attribute = h('select.select', {
    'aria-label': 'Videos with the attribute',
    onchange: () => {
      showAnswerField('');
      scheduleRequest(0);
    },
  });
  const answerContainer = h('span.library-answer');
  const state = selectInput(
    { 'aria-label': 'Videos with tracks in the state', onchange: () => scheduleRequest(0) },
    STATES,
    initialFilters.state,
  );
  const clear = h(
    'button.btn',
    {
      hidden: true,
      onclick: () => {
        reset();
        label.focus();
      },
    },
    'Clear',
  );
  const status = h('span.muted.small.grow', { role: 'status' });
  const element = h(
    'div.library-filters',
    { role: 'group', 'aria-label': 'Videos with such tracks' },
    labelOptions,
    label,
    attribute,
    answerContainer,
    state,
    clear,
    status,
  );
  /** @type {HTMLInputElement|HTMLSelectElement|null} */ let answerField = null;
  /** @type {readonly import('../types.js').Label[]} */ let labels = [];
  /** @type {readonly import('../types.js').Video[]|null} */ let videos = null;
  /** Matching videos with their number of matching tracks; null: all match. @type {ReadonlyMap<string, number>|null} */
  let matches = null;
  let latestRequest = 0;
  /** @type {ReturnType<typeof setTimeout>|undefined} */ let timer;

  /** Show the values to choose from. @param {string} value */
  function showAnswerField(value) {
    const choice = attributeChoices(labels, []).find(({ name }) => name === attribute.value);
    const props = { class: choice?.values.length ? 'select' : 'input', 'aria-label': 'Answer' };
    answerField = !choice
      ? null
      : choice.values.length
        ? h(
            'select',
            { ...props, onchange: () => scheduleRequest(0) },
            h('option', { value: '' }, 'Any value'),
            ...choice.values.map((option) => h('option', { value: String(option) }, answerText(option))),
          )
        : h('input', {
            ...props,
            type: 'search',
            placeholder: 'Any value',
            autocomplete: 'off',
            value,
            oninput: () => scheduleRequest(TYPING_DELAY_MS),
          });
    if (answerField) answerField.value = value;
    fill(answerContainer, answerField);
  }

  /** @returns {LibraryFilters} */
  const readFilters = () => ({ label: label.value, attribute: attribute.value, value: answerField?.value ?? '', state: state.value });

  /** Request after a pause in typing. @param {number} delayMs   ms */
  function scheduleRequest(delayMs) {
    clearTimeout(timer);
    timer = setTimeout(() => void sendRequest(), delayMs);
  }

  async function sendRequest() {
    const requestNumber = ++latestRequest;
    const filters = readFilters();
    const query = matchQuery(filters, labels);
    clear.hidden = Object.values(filters).every((value) => value === '');
    if (query === null || 'error' in query) {
      setText(status, query === null ? '' : query.error);
      matches = null;
      onChange(filters);
      return;
    }
    try {
      for (let remaining = Infinity; remaining > 0;) {
        const found = await app.api.matchingVideos(query, { signal });
        if (requestNumber !== latestRequest || signal.aborted) return;
        // without progress, another request brings nothing
        remaining = found.left < remaining ? found.left : 0;
        matches = new Map(Object.entries(found.videos));
        const tracks = [...matches.values()].reduce((sum, count) => sum + count, 0);
        setText(
          status,
          [
            remaining > 0
              ? `${plural(remaining, 'video')} to search for the first time …`
              : `${plural(tracks, 'track')} in ${plural(matches.size, 'video')}.`,
            found.unreadable > 0 && `The tracks of ${plural(found.unreadable, 'video')} cannot be read here.`,
          ]
            .filter(Boolean)
            .join(' '),
        );
        onChange(filters);
      }
    } catch (thrown) {
      if (signal.aborted || requestNumber !== latestRequest) return;
      setText(status, errorMessage(thrown));
    }
  }

  function reset() {
    label.value = attribute.value = state.value = '';
    showAnswerField('');
    scheduleRequest(0);
  }

  return {
    element,
    reset,
    /** Matching videos with their number of matching tracks; null: all match. */
    matches: () => matches,
    /** @param {import('../state-types.js').State} next */
    update(next) {
      const isFirstLoad = labels.length === 0;
      if (labels !== next.labels) {
        labels = next.labels;
        fill(
          labelOptions,
          h('option', { value: NOT_IN_SET }),
          ...offeredLabels(labels).map(({ name, key }) => h('option', { value: name }, key)),
        );
        const chosenAttribute = isFirstLoad ? initialFilters.attribute : attribute.value;
        const choices = attributeChoices(labels, []);
        fill(attribute, h('option', { value: '' }, 'Any attribute'), ...choices.map(({ name }) => h('option', { value: name }, name)));
        attribute.value = choices.some(({ name }) => name === chosenAttribute) ? chosenAttribute : '';
        attribute.hidden = choices.length === 0;
        showAnswerField(isFirstLoad ? initialFilters.value : (answerField?.value ?? ''));
        scheduleRequest(0);
      }
      if (videos !== null && videos !== next.videos && matches !== null) scheduleRequest(REFRESH_DELAY_MS);
      videos = next.videos;
    },
    destroy: () => clearTimeout(timer),
  };
}
