// @ts-check
/**
 * Fields for parameters of the engine: searchable, checked while typing. The checks are pure and tested without a page.
 */

import { h, setText } from './dom.js';
import { figure } from '../model/format.js';
import { icon, iconButton } from './icons.js';

/** @typedef {import('../types.js').Parameter} Parameter */

/**
 * The value of a parameter without a change.
 *
 * @param {Parameter} parameter
 * @param {string} preset
 * @returns {unknown}
 */
export function presetValue(parameter, preset) {
  return Object.hasOwn(parameter.presets, preset) ? parameter.presets[preset] : parameter.default;
}

/**
 * Parse a typed text; returns the value or an error.
 *
 * @param {Parameter} parameter
 * @param {string} text
 * @returns {{value: unknown}|{error: string}}
 */
export function parseValue(parameter, text) {
  const typed = text.trim();
  if (parameter.type === 'boolean') return { value: typed === 'true' };
  if (parameter.type === 'choice') {
    return parameter.choices?.includes(typed) ? { value: typed } : { error: `Choose one of: ${(parameter.choices ?? []).join(', ')}.` };
  }
  if (parameter.type === 'text') {
    return Array.isArray(parameter.default) ? parseList(typed) : { value: typed === '' && parameter.default === null ? null : typed };
  }
  if (typed === '' && parameter.default === null) return { value: null };
  const value = /^[-+]?(\d+\.?\d*|\.\d+)(e[-+]?\d+)?$/i.test(typed) ? Number(typed) : NaN;
  if (!Number.isFinite(value)) return { error: 'Type a number, such as 0.5 or 1e-3.' };
  if (parameter.type === 'integer' && !Number.isInteger(value)) return { error: 'Type a whole number.' };
  if (parameter.low !== null && value < parameter.low) return { error: `Not below ${figure(parameter.low, 6)}.` };
  if (parameter.high !== null && value > parameter.high) return { error: `Not above ${figure(parameter.high, 6)}.` };
  return { value };
}

/** @param {string} typed @returns {{value: unknown}|{error: string}} */
function parseList(typed) {
  const numbers = typed
    .split(/[\s,;[\]]+/)
    .filter(Boolean)
    .map(Number);
  return numbers.length && numbers.every(Number.isFinite) ? { value: numbers } : { error: 'Type numbers separated by spaces.' };
}

/**
 * @param {readonly Parameter[]} parameters
 * @param {string} text
 * @returns {Parameter[]} parameters with every word in name, section or description; matches in names first
 */
export function findParameters(parameters, text) {
  const words = text.toLowerCase().split(/\s+/).filter(Boolean);
  const found = parameters.filter((parameter) => {
    const searchable = `${parameter.section}.${parameter.name} ${parameter.description}`.toLowerCase();
    return words.every((word) => searchable.includes(word));
  });
  const first = words[0];
  if (!first) return found;
  return found.sort((a, b) => Number(b.name.includes(first)) - Number(a.name.includes(first)));
}

/**
 * @param {object} options
 * @param {readonly Parameter[]} options.parameters
 * @param {(parameter: Parameter) => unknown} options.base   value without a change
 * @param {Record<string, unknown>} [options.initial]        initial changes, by name
 * @param {(changed: number, invalid: number) => void} [options.onChange]
 * @param {(name: string, value: unknown) => string} [options.warn]   a warning about a changed value; empty: none
 * @returns {{element: HTMLElement, changes: () => Record<string, unknown>, invalid: () => number, rebase: (base: (parameter: Parameter) => unknown) => void, reset: () => void, focus: HTMLElement}}
 */
export function createParameterFields(options) {
  let { base } = options;
  /** Typed texts of changed parameters, by name. @type {Map<string, string>} */
  const typed = new Map(Object.entries(options.initial ?? {}).map(([name, value]) => [name, formatValue(value)]));
  const search = h('input.input', { type: 'search', placeholder: 'Name or meaning', 'aria-label': 'Search parameters', oninput: show });
  const changedOnly = h('input', { type: 'checkbox', onchange: show });
  // Initial changes are listed first; later changes stay in their place under the pointer.
  const pinned = new Set(typed.keys());
  const list = h('div.parameters');
  const emptyText = h('p.muted.parameters-none', { role: 'status' });
  const element = h(
    'div.parameter-fields',
    h('div.row', h('div.input-with-icon.grow', icon('search'), search), h('label.row.small', changedOnly, 'Changed only')),
    list,
    emptyText,
  );

  const sections = [...new Set(options.parameters.map((parameter) => parameter.section))];

  function show() {
    let found = findParameters(options.parameters, search.value);
    if (changedOnly.checked) found = found.filter(({ name }) => typed.has(name));
    let section = '';
    const rows = [];
    const grouped = search.value ? found : [...found].sort((a, b) => order(a) - order(b));
    for (const parameter of grouped) {
      const group = pinned.has(parameter.name) ? 'changed' : parameter.section;
      if (!search.value && group !== section) {
        section = group;
        rows.push(h('h4.parameter-section', section));
      }
      rows.push(row(parameter));
    }
    list.replaceChildren(...rows);
    setText(emptyText, found.length ? '' : changedOnly.checked ? 'No parameter is changed.' : 'No parameter matches the search.');
  }

  /** @param {Parameter} parameter */
  const order = (parameter) => (pinned.has(parameter.name) ? -1 : sections.indexOf(parameter.section));

  /** @param {Parameter} parameter */
  function row(parameter) {
    const id = `parameter-${parameter.section}-${parameter.name}`;
    const baseText = formatValue(base(parameter));
    const text = typed.get(parameter.name) ?? baseText;
    const error = h('span.field-error', { id: `${id}-error`, role: 'alert' });
    const warning = h('span.field-warning', { id: `${id}-warning`, role: 'status' });
    const reset = iconButton(
      'undo',
      `Reset ${parameter.name} to ${baseText}`,
      () => {
        change(baseText);
        input.value = baseText;
        input.focus();
      },
      `Reset to ${baseText || 'nothing'}`,
    );
    const range = parameter.type === 'number' || parameter.type === 'integer' ? rangeText(parameter) : '';
    const attributes = { id, value: text, 'aria-describedby': `${id}-text ${id}-error ${id}-warning`, oninput: () => change(input.value) };
    const choices = parameter.type === 'boolean' ? ['true', 'false'] : parameter.type === 'choice' ? (parameter.choices ?? []) : null;
    const input = choices
      ? h(
          'select.select',
          { ...attributes },
          ...choices.map((choice) =>
            h('option', { value: choice, selected: choice === text }, choice === 'true' ? 'yes' : choice === 'false' ? 'no' : choice),
          ),
        )
      : h('input.input.mono', {
          type: 'text',
          inputmode: parameter.type === 'text' ? 'text' : 'decimal',
          autocomplete: 'off',
          spellcheck: 'false',
          placeholder: baseText === '' ? 'unset' : null,
          ...attributes,
        });
    const element = h(
      'div.parameter',
      h('label.parameter-name.mono', { for: id }, parameter.name),
      h('div.parameter-input.row', input, reset),
      h('p.parameter-text.muted.small', { id: `${id}-text` }, [parameter.description, range].filter(Boolean).join(' · ')),
      error,
      warning,
    );

    /** @param {string} value */
    function change(value) {
      if (value.trim() === baseText) typed.delete(parameter.name);
      else typed.set(parameter.name, value);
      validate();
      options.onChange?.(typed.size, invalid());
    }
    function validate() {
      const result = typed.has(parameter.name) ? parseValue(parameter, typed.get(parameter.name) ?? '') : null;
      const isInvalid = result && 'error' in result;
      setText(error, isInvalid ? result.error : '');
      setText(warning, result && 'value' in result ? (options.warn?.(parameter.name, result.value) ?? '') : '');
      input.setAttribute('aria-invalid', String(Boolean(isInvalid)));
      element.classList.toggle('parameter-changed', typed.has(parameter.name));
      reset.hidden = !typed.has(parameter.name);
    }
    validate();
    return element;
  }

  function invalid() {
    return options.parameters.filter(
      (parameter) => typed.has(parameter.name) && 'error' in parseValue(parameter, typed.get(parameter.name) ?? ''),
    ).length;
  }

  show();
  return {
    element,
    focus: search,
    invalid,
    changes() {
      /** @type {Record<string, unknown>} */ const changes = {};
      for (const parameter of options.parameters) {
        const result = typed.has(parameter.name) ? parseValue(parameter, typed.get(parameter.name) ?? '') : null;
        if (result && 'value' in result) changes[parameter.name] = result.value;
      }
      return changes;
    },
    /** Reset all parameters. */
    reset() {
      typed.clear();
      pinned.clear();
      show();
      options.onChange?.(0, 0);
    },
    rebase(next) {
      base = next;
      show();
    },
  };
}

/** @param {unknown} value */
function formatValue(value) {
  return value === null || value === undefined ? '' : Array.isArray(value) ? value.join(' ') : String(value);
}

/** @param {Parameter} parameter */
function rangeText({ low, high }) {
  if (low !== null && high !== null) return `${figure(low, 6)} to ${figure(high, 6)}`;
  if (low !== null) return `at least ${figure(low, 6)}`;
  return high !== null ? `at most ${figure(high, 6)}` : '';
}
