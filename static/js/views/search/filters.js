// @ts-check
/** The filters of the search: one row, and a second one for rarer filters. */

import { hasSecondaryFilter } from '../../model/search.js';
import { fill, h, selectInput, setAttribute } from '../dom.js';
import { icon } from '../icons.js';

/** @typedef {import('../../model/search.js').SearchFilters} SearchFilters */

/** How a field shows a filter and sets it. @typedef {{read: (filters: SearchFilters) => string, write: (text: string) => Partial<SearchFilters>}} Codec */

/** Pause in typing before a search, ms. */
const TYPING_DELAY_MS = 350;

/** @param {'text'|'video'|'size_min'|'size_max'|'runs'} key @returns {Codec} */
const word = (key) => ({ read: (filters) => filters[key], write: (text) => ({ [key]: text.trim() }) });

/** Several words, with ; between. @param {'label'|'attribute'|'author'|'tag'} key @returns {Codec} */
const list = (key) => ({
  read: (filters) => filters[key].join('; '),
  write(text) {
    const words = text.split(';').map((one) => one.trim());
    return { [key]: words.filter(Boolean) };
  },
});

/** A share that is shown as a percentage. @param {'uncertainty_min'|'uncertainty_max'} key @returns {Codec} */
const share = (key) => ({
  read: ({ [key]: value }) => (value === '' ? '' : String(Number((Number(value) * 100).toFixed(4)))),
  write: (text) => ({ [key]: text.trim() === '' ? '' : String(Number((Number(text) / 100).toFixed(6))) }),
});

/** @param {'since'|'until'} key @returns {Codec} */
const day = (key) => ({ read: (filters) => filters[key].slice(0, 10), write: (text) => ({ [key]: text }) });

/** @param {object} setup @param {(filters: SearchFilters) => void} setup.onChange @param {AbortSignal} setup.signal */
export function createSearchFilters({ onChange, signal }) {
  /** @type {SearchFilters|null} */ let current = null;
  /** @type {ReturnType<typeof setTimeout>|undefined} */ let timer;
  signal.addEventListener('abort', () => clearTimeout(timer), { once: true });

  /** @param {Partial<SearchFilters>} part */
  function applyChange(part) {
    clearTimeout(timer);
    if (current) onChange({ ...current, ...part });
  }

  /** @type {(() => void)[]} functions that show the filters again */
  const refreshers = [];

  /** @param {string} name @param {Record<string, unknown>} props @param {Codec} codec */
  function input(name, props, { read, write }) {
    const field = h('input.input', { type: 'text', autocomplete: 'off', 'aria-label': name, ...props });
    // a half-typed name is not searched for
    const onInput = () => {
      clearTimeout(timer);
      timer = setTimeout(() => applyChange(write(field.value)), field.dataset.whole ? 900 : TYPING_DELAY_MS);
    };
    field.addEventListener('input', onInput, { signal });
    field.addEventListener('change', () => applyChange(write(field.value)), { signal });
    refreshers.push(() => {
      if (current && document.activeElement !== field) field.value = read(current);
    });
    return field;
  }

  /** @param {string} name @param {readonly (readonly [string, string])[]} options @param {Codec} codec */
  function choice(name, options, { read, write }) {
    const field = selectInput({ 'aria-label': name, title: name, onchange: () => applyChange(write(field.value)) }, options);
    refreshers.push(() => {
      if (!current) return;
      const value = read(current);
      if (![...field.options].some((option) => option.value === value)) field.append(h('option', { value }, value.replaceAll(' ', ' or ')));
      field.value = value;
    });
    return field;
  }

  const names = h('datalist', { id: 'search-labels' });
  const tags = h('datalist', { id: 'search-tags' });
  const label = input(
    'Label',
    {
      placeholder: 'Label, such as 60',
      list: 'search-labels',
      dataset: { whole: '1' },
      title: 'Name or words of it, key, alias, short name, or #number; several with ; between; none: without a label',
    },
    list('label'),
  );
  const state = choice(
    'State',
    [
      ['', 'Any state'],
      ['open', 'Open'],
      ['needs_work', 'Needs work'],
      ['open needs_work', 'Undecided'],
      ['accepted', 'Accepted'],
      ['rejected', 'False positive'],
      ['ignored', 'Ignored'],
    ],
    { read: (filters) => filters.state.join(' '), write: (value) => ({ state: value === '' ? [] : value.split(' ') }) },
  );
  const percent = { type: 'number', min: 0, max: 100, step: 'any', inputmode: 'decimal' };
  const minUncertainty = input(
    'Uncertainty from, %',
    { ...percent, placeholder: '0', title: 'Probability that a person changes the track, %. Less than 70 % certain means 30 or more' },
    share('uncertainty_min'),
  );
  const maxUncertainty = input(
    'Uncertainty to, %',
    { ...percent, placeholder: '100', title: 'Probability that a person changes the track, %' },
    share('uncertainty_max'),
  );
  const pixels = { type: 'number', min: 0, step: 'any', inputmode: 'decimal' };
  const minSize = input(
    'Smallest size, px',
    { ...pixels, placeholder: 'any', title: 'Longer side of its largest box, px' },
    word('size_min'),
  );
  const maxSize = input(
    'Largest size, px',
    { ...pixels, placeholder: 'any', title: 'Longer side of its largest box, px' },
    word('size_max'),
  );
  const text = input('Words of notes', { type: 'search', placeholder: 'Words of notes' }, word('text'));
  const attribute = input(
    'Attribute',
    { placeholder: 'name=answer', title: 'Such as dirty=yes, or dirty alone; separate several with ; (all must hold)' },
    list('attribute'),
  );
  const author = input(
    'Edited last by',
    { placeholder: 'anybody', title: 'The name under Preferences; several with ; between' },
    list('author'),
  );
  const since = input('Edited since', { type: 'date', title: 'Last edit on this day (UTC) or later' }, day('since'));
  const until = input('Edited until', { type: 'date', title: 'Last edit on this day (UTC) or earlier' }, day('until'));
  const tag = input('Tag', { placeholder: 'any', list: 'search-tags', title: 'Of the video; several with ; between' }, list('tag'));
  const video = input('Video', { placeholder: 'any', title: 'Words of its name' }, word('video'));
  const runs = choice(
    'Runs',
    [
      ['current', 'Newest run'],
      ['all', 'All runs'],
    ],
    word('runs'),
  );
  const sort = choice(
    'Order',
    [
      ['uncertainty desc', 'Most uncertain first'],
      ['uncertainty asc', 'Most certain first'],
      ['size desc', 'Largest first'],
      ['size asc', 'Smallest first'],
      ['edited desc', 'Newest edit first'],
      ['edited asc', 'Oldest edit first'],
    ],
    { read: ({ sort, order }) => `${sort} ${order}`, write: (value) => ({ sort: value.split(' ')[0], order: value.split(' ')[1] }) },
  );
  const moreButton = h(
    'button.btn',
    {
      'aria-expanded': 'false',
      'aria-controls': 'search-further',
      title: 'Filter by attribute, author, day, tag, video or run',
      onclick: () => open(moreButton.getAttribute('aria-expanded') !== 'true'),
    },
    icon('filter'),
    'More',
  );
  const secondRow = h(
    'div.search-row',
    { id: 'search-further', hidden: true },
    labelled('Attribute', attribute),
    labelled('Edited by', author),
    labelled('from', since),
    labelled('to', until),
    labelled('Tag', tag),
    labelled('Video', video),
    runs,
  );

  /** @param {boolean} isOpen */
  function open(isOpen) {
    setAttribute(moreButton, 'aria-expanded', String(isOpen));
    secondRow.hidden = !isOpen;
  }

  const firstRow = h(
    'div.search-row',
    h('span.input-with-icon.search-label', icon('search'), label),
    names,
    tags,
    state,
    h('span.search-range', h('span.muted', 'Uncertainty'), minUncertainty, h('span.muted', '–'), maxUncertainty, h('span.muted', '%')),
    h('span.search-range', h('span.muted', 'Size'), minSize, h('span.muted', '–'), maxSize, h('span.muted', 'px')),
    text,
    sort,
    moreButton,
  );

  return {
    element: h('div.search-filters', { role: 'search' }, firstRow, secondRow),
    label,
    /** @param {SearchFilters} filters */
    show(filters) {
      const before = current;
      current = filters;
      refreshers.forEach((show) => show());
      if (hasSecondaryFilter(filters) && (before === null || !hasSecondaryFilter(before))) open(true);
    },
    /** Offer completions for the fields. @param {readonly import('../../types.js').Label[]} labels @param {readonly import('../../types.js').Video[]} videos */
    offer(labels, videos) {
      fill(
        names,
        labels.filter((one) => !one.hidden && one.merged_into === null).map((one) => h('option', { value: one.name }, one.short)),
      );
      fill(
        tags,
        [...new Set(videos.flatMap((one) => one.tags ?? []))].sort().map((value) => h('option', { value })),
      );
    },
  };
}

/** @param {string} text @param {HTMLElement} field */
function labelled(text, field) {
  return h('label.search-named', h('span.muted', text), field);
}
