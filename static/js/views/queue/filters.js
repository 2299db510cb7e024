// @ts-check
/** Filters and sort order of the queue. */

import { answerText, attributeChoices } from '../../model/attributes.js';
import { NO_CLASS } from '../../model/documents.js';
import { labelFor, resolveLabelId } from '../../model/labels.js';
import { scoreRange } from '../../model/queue.js';
import { changeFilter } from '../../store/actions/review.js';
import { fill, h, returnFocusToPicture, selectInput, scrollFocusedIntoView, setAttribute } from '../dom.js';
import { count, figure } from '../../model/format.js';
import { icon } from '../icons.js';

/** @typedef {import('../../state-types.js').QueueFilter} QueueFilter */

/** Maximum number of values of an attribute to choose from. */
const MAX_ATTRIBUTE_VALUES = 200;
const REVIEWS = /** @type {const} */ ([
  ['all', 'Any state'],
  ['open', 'Open'],
  ['needs_work', 'Needs work'],
  ['accepted', 'Accepted'],
  ['rejected', 'False positive'],
]);
const SORTS = /** @type {const} */ ([
  ['uncertainty', 'By uncertainty'],
  ['time', 'By time'],
  ['class', 'By label'],
  ['score', 'By score'],
]);
const UNCERTAINTIES = /** @type {const} */ ([
  ['0', 'Any uncertainty'],
  ['0.1', '≥ 10 %'],
  ['0.25', '≥ 25 %'],
  ['0.5', '≥ 50 %'],
  ['0.75', '≥ 75 %'],
]);

/** @param {import('../../page-types.js').ViewApp} app */
export function createQueueFilters(app) {
  /** @param {Partial<QueueFilter>} change */
  const filter = (change) => app.store.dispatch(changeFilter, change);
  /** @param {string} name @param {readonly (readonly [string, string])[]} options @param {(value: string) => Partial<QueueFilter>} read */
  const select = (name, options, read) => {
    const element = selectInput({ 'aria-label': name, title: name, onchange: () => filter(read(element.value)) }, options);
    return element;
  };
  const text = h('input.input', {
    type: 'search',
    placeholder: 'Label, number, reason or note',
    'aria-label': 'Search tracks',
    title: 'Every word must occur. Attribute values are searched as well, such as dirty=yes',
    oninput: () => filter({ text: text.value }),
  });
  const review = select('Review state', REVIEWS, (value) => ({ review: /** @type {QueueFilter['review']} */ (value) }));
  const sort = select('Sort by', SORTS, (value) => ({ sort: /** @type {QueueFilter['sort']} */ (value) }));
  const uncertainty = select('Minimum uncertainty', UNCERTAINTIES, (value) => ({ least_uncertainty: Number(value) }));
  const labelSelect = select('Label', [['', 'All labels']], (value) => ({ class_id: value === '' ? null : Number(value) }));
  labelSelect.classList.add('queue-label');
  const attribute = select('Attribute', [['', 'Any attribute']], (value) => ({ attribute: value === '' ? null : JSON.parse(value) }));
  const notesButton = h(
    'button.btn.btn-icon.queue-noted',
    {
      title: 'Only tracks with notes',
      'aria-label': 'Only tracks with notes',
      onclick: () => filter({ with_notes: notesButton.getAttribute('aria-pressed') !== 'true' }),
    },
    icon('note'),
  );
  const minScore = scoreInput('queue-min-score', 'Minimum score', 'Score ≥', (score) => filter({ least_score: score }));
  const maxScore = scoreInput('queue-max-score', 'Maximum score', 'Score ≤', (score) => filter({ most_score: score }));
  const element = h(
    'div.queue-filters',
    h('div.queue-search', h('span.input-with-icon.grow', icon('search'), text), notesButton),
    sort,
    review,
    uncertainty,
    labelSelect,
    minScore,
    maxScore,
    attribute,
  );
  returnFocusToPicture(element);
  scrollFocusedIntoView(element);
  let shownOptions = '';
  /** The inputs of the present list of attributes. @type {unknown[]} */
  let listedInputs = [];

  /**
   * List the attributes of the tracks' labels, and further values that people have set.
   * @param {QueueFilter['attribute']} now
   * @param {readonly import('../../model/track_entries.js').TrackEntry[]} entries
   * @param {readonly import('../../types.js').Label[]} labels
   */
  function listAttributes(now, entries, labels) {
    const selectedValue = now === null ? '' : JSON.stringify(now);
    if (entries !== listedInputs[0] || labels !== listedInputs[1]) {
      listedInputs = [entries, labels];
      const trackLabels = [...new Set(entries.map(({ class_id }) => labelFor(labels, class_id)))].filter((label) => label !== undefined);
      const choices = attributeChoices(
        trackLabels,
        entries.flatMap(({ doc }) => doc ?? []),
      );
      fill(
        attribute,
        h('option', { value: '' }, 'Any attribute'),
        choices.map(({ name, values }) =>
          h(
            'optgroup',
            { label: name },
            [null, ...values.slice(0, MAX_ATTRIBUTE_VALUES)].map((value) =>
              h('option', { value: JSON.stringify({ name, value }) }, `${name}: ${value === null ? 'any value' : answerText(value)}`),
            ),
          ),
        ),
      );
    }
    // also an attribute that no track has any more
    if (selectedValue !== '' && ![...attribute.options].some(({ value }) => value === selectedValue))
      attribute.append(
        h('option', { value: selectedValue }, `${now?.name}: ${now?.value === null ? 'any value' : answerText(now?.value ?? '')}`),
      );
    attribute.hidden = attribute.options.length < 2;
    attribute.value = selectedValue;
  }

  return {
    element,
    /**
     * @param {QueueFilter} now
     * @param {readonly import('../../model/track_entries.js').TrackEntry[]} entries
     * @param {readonly import('../../types.js').Label[]} labels
     */
    update(now, entries, labels) {
      /** Tracks by label. @type {Map<number, number>} */
      const counts = new Map();
      for (const entry of entries) {
        const id = resolveLabelId(labels, entry.class_id ?? NO_CLASS);
        counts.set(id, (counts.get(id) ?? 0) + 1);
      }
      const chosen = now.class_id === null ? null : resolveLabelId(labels, now.class_id);
      const offered = [...labels, { id: NO_CLASS, name: 'Without a label' }].filter(({ id }) => counts.has(id) || id === chosen);
      const options = offered.map(({ id, name }) => /** @type {const} */ ([String(id), `${name} (${count(counts.get(id) ?? 0)})`]));
      const key = JSON.stringify(options);
      if (key !== shownOptions) {
        shownOptions = key;
        fill(
          labelSelect,
          h('option', { value: '' }, 'All labels'),
          options.map(([value, text]) => h('option', { value }, text)),
        );
      }
      if (text.value !== now.text) text.value = now.text;
      setAttribute(notesButton, 'aria-pressed', String(now.with_notes));
      review.value = now.review;
      sort.value = now.sort;
      listAttributes(now.attribute, entries, labels);
      uncertainty.value = String(now.least_uncertainty);
      labelSelect.value = chosen === null ? '' : String(chosen);
      const range = scoreRange(entries);
      for (const [input, value, name] of /** @type {const} */ ([
        [minScore, now.least_score, 'Least'],
        [maxScore, now.most_score, 'Maximum'],
      ])) {
        setAttribute(
          input,
          'title',
          `${name} score of a track: the best of its detections${range ? `, here ${figure(range[0])} to ${figure(range[1])}` : ''}`,
        );
        // a half-typed value, such as a minus sign, is kept
        if (document.activeElement !== input) input.value = value === null ? '' : String(value);
      }
    },
  };
}

/** @param {string} className @param {string} name @param {string} placeholder @param {(score: number|null) => void} change */
function scoreInput(className, name, placeholder, change) {
  const input = h(`input.input.${className}`, {
    type: 'number',
    step: 'any',
    placeholder,
    'aria-label': name,
    autocomplete: 'off',
    oninput: () => change(input.value === '' ? null : input.valueAsNumber),
  });
  return input;
}
