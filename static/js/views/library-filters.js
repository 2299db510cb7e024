// @ts-check
/** Filters of the library: videos with a track of a label, an attribute value and a review state. */

import { sentence } from '../api/errors.js';
import { answerText, attributeChoices } from '../model/attributes.js';
import { NO_CLASS } from '../model/documents.js';
import { labelFinder } from '../model/label_finder.js';
import { offeredLabels } from '../model/labels.js';
import { fill, h, setText } from './dom.js';
import { plural } from '../model/format.js';

/** @typedef {{label: string, attribute: string, value: string, state: string}} Chosen   as typed; empty: any */

/** @type {Chosen} */
export const NOTHING_CHOSEN = Object.freeze({ label: '', attribute: '', value: '', state: '' });
const NONE = 'Not in the set';
const STATES = [
  ['', 'Any state'],
  ['open', 'Open'],
  ['needs_work', 'Needs work'],
  ['accepted', 'Accepted'],
  ['rejected', 'False positive'],
  ['ignored', 'Ignored'],
];
/** Pause in typing before a request, ms. */
const RESTS = 250;
/** Delay of a new request after a change of the library, ms. */
const AGAIN = 1000;

/**
 * The query for the server; null: no filter is set.
 *
 * @param {Chosen} chosen
 * @param {readonly import('../types.js').Label[]} labels
 * @returns {{label?: string, attribute?: string, value?: string, state?: string}|{error: string}|null}
 */
export function questionOf({ label, attribute, value, state }, labels) {
  const typed = label.trim();
  const none = typed.toLowerCase() === NONE.toLowerCase();
  const found = typed && !none ? labelFinder(labels).find(typed) : null;
  if (typed && !none && (found === null || (found.how === 'number' && !typed.startsWith('#'))))
    return { error: `No label is called “${typed.slice(0, 60)}”.` };
  const asked = {
    ...(typed && { label: none ? String(NO_CLASS) : (found?.label.key ?? '') }),
    ...(attribute && { attribute, ...(value.trim() && { value: value.trim() }) }),
    ...(state && { state }),
  };
  return Object.keys(asked).length ? asked : null;
}

/**
 * @param {import('../page-types.js').App} app
 * @param {{chosen: Chosen, changed: (chosen: Chosen) => void, signal: AbortSignal}} options   changed: called when the matching videos change
 */
export function createLibraryFilters(app, { chosen, changed, signal }) {
  const names = h('datalist', { id: 'library-labels' });
  const label = h('input.input', {
    type: 'search',
    list: 'library-labels',
    placeholder: 'Any label',
    autocomplete: 'off',
    dir: 'auto',
    'aria-label': 'Videos with the label',
    value: chosen.label,
    oninput: () => turn(RESTS),
  });
  const attribute = h('select.select', {
    'aria-label': 'Videos with the attribute',
    onchange: () => {
      showAnswers('');
      turn(0);
    },
  });
  const place = h('span.library-answer');
  const state = h(
    'select.select',
    { 'aria-label': 'Videos with tracks in the state', onchange: () => turn(0) },
    ...STATES.map(([value, text]) => h('option', { value }, text)),
  );
  state.value = chosen.state;
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
    names,
    label,
    attribute,
    place,
    state,
    clear,
    status,
  );
  /** @type {HTMLInputElement|HTMLSelectElement|null} */
  let answer = null;
  /** @type {readonly import('../types.js').Label[]} */
  let labels = [];
  /** @type {readonly import('../types.js').Video[]|null} */
  let videos = null;
  /** Matching videos with their number of matching tracks; null: all match. @type {ReadonlyMap<string, number>|null} */
  let passing = null;
  let asked = 0;
  /** @type {ReturnType<typeof setTimeout>|undefined} */
  let timer;

  /** Show the values to choose from. @param {string} value */
  function showAnswers(value) {
    const choice = attributeChoices(labels, []).find(({ name }) => name === attribute.value);
    const given = { class: choice?.values.length ? 'select' : 'input', 'aria-label': 'Answer' };
    answer = !choice
      ? null
      : choice.values.length
        ? h(
            'select',
            { ...given, onchange: () => turn(0) },
            h('option', { value: '' }, 'Any value'),
            ...choice.values.map((one) => h('option', { value: String(one) }, answerText(one))),
          )
        : h('input', { ...given, type: 'search', placeholder: 'Any value', autocomplete: 'off', value, oninput: () => turn(RESTS) });
    if (answer) answer.value = value;
    fill(place, answer);
  }

  /** @returns {Chosen} */
  const read = () => ({ label: label.value, attribute: attribute.value, value: answer?.value ?? '', state: state.value });

  /** Request after a pause in typing. @param {number} rests   ms */
  function turn(rests) {
    clearTimeout(timer);
    timer = setTimeout(() => void ask(), rests);
  }

  async function ask() {
    const mine = ++asked;
    const now = read();
    const question = questionOf(now, labels);
    clear.hidden = Object.values(now).every((value) => value === '');
    if (question === null || 'error' in question) {
      setText(status, question === null ? '' : question.error);
      passing = null;
      changed(now);
      return;
    }
    try {
      for (let left = Infinity; left > 0;) {
        const found = await app.api.matchingVideos(question, { signal });
        if (mine !== asked || signal.aborted) return;
        // without progress, another request brings nothing
        left = found.left < left ? found.left : 0;
        passing = new Map(Object.entries(found.videos));
        const tracks = [...passing.values()].reduce((sum, count) => sum + count, 0);
        setText(
          status,
          [
            left > 0
              ? `${plural(left, 'video')} to search for the first time …`
              : `${plural(tracks, 'track')} in ${plural(passing.size, 'video')}.`,
            found.unreadable > 0 && `The tracks of ${plural(found.unreadable, 'video')} cannot be read here.`,
          ]
            .filter(Boolean)
            .join(' '),
        );
        changed(now);
      }
    } catch (thrown) {
      if (signal.aborted || mine !== asked) return;
      setText(status, sentence(thrown));
    }
  }

  function reset() {
    label.value = attribute.value = state.value = '';
    showAnswers('');
    turn(0);
  }

  return {
    element,
    reset,
    /** Matching videos with their number of matching tracks; null: all match. */
    passing: () => passing,
    /** @param {import('../state-types.js').State} next */
    update(next) {
      const first = labels.length === 0;
      if (labels !== next.labels) {
        labels = next.labels;
        fill(names, h('option', { value: NONE }), ...offeredLabels(labels).map(({ name, key }) => h('option', { value: name }, key)));
        const wanted = first ? chosen.attribute : attribute.value;
        const choices = attributeChoices(labels, []);
        fill(attribute, h('option', { value: '' }, 'Any attribute'), ...choices.map(({ name }) => h('option', { value: name }, name)));
        attribute.value = choices.some(({ name }) => name === wanted) ? wanted : '';
        attribute.hidden = choices.length === 0;
        showAnswers(first ? chosen.value : (answer?.value ?? ''));
        turn(0);
      }
      if (videos !== null && videos !== next.videos && passing !== null) turn(AGAIN);
      videos = next.videos;
    },
    destroy: () => clearTimeout(timer),
  };
}
