// @ts-check
/** The filters of the search: one row, and a second one for rarer filters. */

import { hasSecondaryFilter } from '../../model/search.js';
import { fill, h, setAttribute } from '../dom.js';
import { icon } from '../icons.js';

/** @typedef {import('../../model/search.js').SearchFilters} SearchFilters */

/** Pause in typing before a search, ms. */
const TYPING_DELAY_MS = 350;

/**
 * @param {object} setup
 * @param {(filters: SearchFilters) => void} setup.onChange
 * @param {AbortSignal} setup.signal
 */
export function createSearchFilters({ onChange, signal }) {
  /** @type {SearchFilters|null} */
  let current = null;
  /** @type {ReturnType<typeof setTimeout>|undefined} */
  let timer;
  signal.addEventListener('abort', () => clearTimeout(timer), { once: true });

  /** @param {Partial<SearchFilters>} part */
  function applyChange(part) {
    clearTimeout(timer);
    if (current) onChange({ ...current, ...part });
  }

  /** @type {(() => void)[]} functions that show the filters again */
  const refreshers = [];

  /**
   * @param {string} name
   * @param {Record<string, unknown>} props
   * @param {(filters: SearchFilters) => string} read
   * @param {(text: string) => Partial<SearchFilters>} write
   */
  function input(name, props, read, write) {
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

  /** @param {string} text */
  const splitList = (text) =>
    text
      .split(';')
      .map((word) => word.trim())
      .filter(Boolean);
  /** @param {string} share */
  const toPercent = (share) => (share === '' ? '' : String(Number((Number(share) * 100).toFixed(4))));
  /** @param {string} text */
  const fromPercent = (text) => (text.trim() === '' ? '' : String(Number((Number(text) / 100).toFixed(6))));

  /** @param {string} name @param {[string, string][]} options @param {(filters: SearchFilters) => string} read @param {(value: string) => Partial<SearchFilters>} write */
  function choice(name, options, read, write) {
    const field = h(
      'select.select',
      { 'aria-label': name, title: name, onchange: () => applyChange(write(field.value)) },
      options.map(([value, text]) => h('option', { value }, text)),
    );
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
    (f) => f.label.join('; '),
    (text) => ({ label: splitList(text) }),
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
    (f) => f.state.join(' '),
    (value) => ({ state: value === '' ? [] : value.split(' ') }),
  );
  const percent = { type: 'number', min: 0, max: 100, step: 'any', inputmode: 'decimal' };
  const minUncertainty = input(
    'Uncertainty from, %',
    { ...percent, placeholder: '0', title: 'Probability that a person changes the track, %. Less than 70 % certain means 30 or more' },
    (f) => toPercent(f.uncertainty_min),
    (text) => ({ uncertainty_min: fromPercent(text) }),
  );
  const maxUncertainty = input(
    'Uncertainty to, %',
    { ...percent, placeholder: '100', title: 'Probability that a person changes the track, %' },
    (f) => toPercent(f.uncertainty_max),
    (text) => ({ uncertainty_max: fromPercent(text) }),
  );
  const pixels = { type: 'number', min: 0, step: 'any', inputmode: 'decimal' };
  const minSize = input(
    'Smallest size, px',
    { ...pixels, placeholder: 'any', title: 'Longer side of its largest box, px' },
    (f) => f.size_min,
    (text) => ({ size_min: text.trim() }),
  );
  const maxSize = input(
    'Largest size, px',
    { ...pixels, placeholder: 'any', title: 'Longer side of its largest box, px' },
    (f) => f.size_max,
    (text) => ({ size_max: text.trim() }),
  );
  const text = input(
    'Words of notes',
    { type: 'search', placeholder: 'Words of notes' },
    (f) => f.text,
    (value) => ({ text: value.trim() }),
  );
  const attribute = input(
    'Attribute',
    { placeholder: 'name=answer', title: 'Such as dirty=yes, or dirty alone; separate several with ; (all must hold)' },
    (f) => f.attribute.join('; '),
    (value) => ({ attribute: splitList(value) }),
  );
  const author = input(
    'Edited last by',
    { placeholder: 'anybody', title: 'The name under Preferences; several with ; between' },
    (f) => f.author.join('; '),
    (value) => ({ author: splitList(value) }),
  );
  const since = input(
    'Edited since',
    { type: 'date', title: 'Last edit on this day (UTC) or later' },
    (f) => f.since.slice(0, 10),
    (value) => ({ since: value }),
  );
  const until = input(
    'Edited until',
    { type: 'date', title: 'Last edit on this day (UTC) or earlier' },
    (f) => f.until.slice(0, 10),
    (value) => ({ until: value }),
  );
  const tag = input(
    'Tag',
    { placeholder: 'any', list: 'search-tags', title: 'Of the video; several with ; between' },
    (f) => f.tag.join('; '),
    (value) => ({ tag: splitList(value) }),
  );
  const video = input(
    'Video',
    { placeholder: 'any', title: 'Words of its name' },
    (f) => f.video,
    (value) => ({ video: value.trim() }),
  );
  const runs = choice(
    'Runs',
    [
      ['current', 'Newest run'],
      ['all', 'All runs'],
    ],
    (f) => f.runs,
    (value) => ({ runs: value }),
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
    (f) => `${f.sort} ${f.order}`,
    (value) => ({ sort: value.split(' ')[0], order: value.split(' ')[1] }),
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
