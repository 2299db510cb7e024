// @ts-check
/** Elements without HTML strings: names and notes are always shown as text. */

/** @typedef {Node|string|number|null|undefined|false} Child */
/** @typedef {Child|Child[]} Children */
/** @typedef {Record<string, unknown>} Props */

const SVG = 'http://www.w3.org/2000/svg';

/** Set as properties, because their attribute is only the initial value or cannot be `false`. */
const PROPERTIES = new Set(['value', 'checked', 'disabled', 'indeterminate', 'selected', 'readOnly', 'tabIndex']);

/**
 * @template Tags
 * @template {string} S
 * @typedef {S extends keyof Tags ? Tags[S] : S extends `${infer K}.${string}` ? (K extends keyof Tags ? Tags[K] : never) : never} ElementOf
 */

/**
 * An HTML element: `h('p.muted', { title: 'of all' }, 'None')`.
 *
 * @template {keyof HTMLElementTagNameMap | `${keyof HTMLElementTagNameMap}.${string}`} S
 * @param {S} selector   tag and classes
 * @param {...(Props|Children)} rest   optional properties: `dataset: {}`, `style: {'--part': '3%'}`, `onclick:
 *   listener`, and attributes (`true`: empty; `false`, null, undefined: omitted); then children: strings become text;
 *   null, undefined and false are omitted
 * @returns {ElementOf<HTMLElementTagNameMap, S>}
 */
export function h(selector, ...rest) {
  const [tag, ...classes] = selector.split('.');
  const element = document.createElement(tag);
  if (tag === 'button') element.setAttribute('type', 'button');
  return /** @type {ElementOf<HTMLElementTagNameMap, S>} */ (initElement(element, classes, rest));
}

/**
 * A list of options.
 *
 * @param {Props} props
 * @param {readonly (readonly [string, string])[]} options   value and text of each
 * @param {string} [value]   of the selected option; default: the first one
 */
export function selectInput(props, options, value) {
  const element = h('select.select', props, ...options.map(([key, text]) => h('option', { value: key }, text)));
  if (value !== undefined) element.value = value;
  return element;
}

/**
 * An SVG element; like `h`.
 *
 * @template {keyof SVGElementTagNameMap | `${keyof SVGElementTagNameMap}.${string}`} S
 * @param {S} selector
 * @param {...(Props|Children)} rest
 * @returns {ElementOf<SVGElementTagNameMap, S>}
 */
export function s(selector, ...rest) {
  const [tag, ...classes] = selector.split('.');
  return /** @type {ElementOf<SVGElementTagNameMap, S>} */ (initElement(document.createElementNS(SVG, tag), classes, rest));
}

/** @param {Element} element @param {string[]} classes @param {(Props|Children)[]} rest */
function initElement(element, classes, rest) {
  if (classes.length > 0) element.setAttribute('class', classes.join(' '));
  const [first] = rest;
  const props = first && Object.getPrototypeOf(first) === Object.prototype ? /** @type {Props} */ (rest.shift()) : {};
  setProps(element, props);
  append(element, /** @type {Children[]} */ (rest));
  return element;
}

/**
 * Set the properties of an element as `h` takes them.
 *
 * @param {Element} element
 * @param {Props} props
 */
export function setProps(element, props) {
  for (const [name, value] of Object.entries(props)) {
    if (name.startsWith('on') && typeof value === 'function') {
      element.addEventListener(name.slice(2), /** @type {EventListener} */ (value));
    } else if (name === 'dataset') {
      Object.assign(/** @type {HTMLElement} */ (element).dataset, value);
    } else if (name === 'style') {
      for (const [key, part] of Object.entries(/** @type {Record<string, string>} */ (value))) {
        /** @type {HTMLElement} */ (element).style.setProperty(key, part);
      }
    } else if (PROPERTIES.has(name)) {
      if (value !== undefined) Reflect.set(element, name, value ?? '');
    } else {
      setAttribute(element, name, value);
    }
  }
}

/**
 * Set or remove an attribute; the document changes only if the value does.
 *
 * @param {Element} element
 * @param {string} name
 * @param {unknown} value   false, null, undefined: removed; true: empty
 */
export function setAttribute(element, name, value) {
  if (value === false || value === null || value === undefined) {
    if (element.hasAttribute(name)) element.removeAttribute(name);
    return;
  }
  const text = value === true ? '' : String(value);
  if (element.getAttribute(name) !== text) element.setAttribute(name, text);
}

/**
 * Scroll a row so that the focused control is completely visible: browsers may leave a button half visible. A press of
 * the pointer does not scroll, because the control must stay under the pointer.
 *
 * @param {HTMLElement} row
 */
export function scrollFocusedIntoView(row) {
  row.addEventListener('focusin', ({ target }) => {
    if (target instanceof Element && target.matches(':focus-visible')) target.scrollIntoView({ block: 'nearest', inline: 'nearest' });
  });
}

/**
 * Make controls one tab stop, following the ARIA practices for toolbars: arrows move between controls, Home and End go
 * to the first and the last. The tab stop is the control that was focused last.
 *
 * @param {HTMLElement} bar
 * @param {readonly HTMLElement[]} controls   with `tabIndex` -1
 */
export function addRovingTabIndex(bar, controls) {
  let tabStop = controls[0];
  tabStop.tabIndex = 0;
  bar.addEventListener('focusin', ({ target }) => {
    const next = controls.find((control) => control === target);
    if (!next) return;
    tabStop.tabIndex = -1;
    tabStop = next;
    tabStop.tabIndex = 0;
  });
  bar.addEventListener('keydown', (event) => {
    if (event.altKey || event.ctrlKey || event.metaKey || event.shiftKey) return;
    const index = controls.indexOf(tabStop);
    const next = { ArrowRight: index + 1, ArrowLeft: index - 1, Home: 0, End: controls.length - 1 }[event.key];
    if (next === undefined) return;
    event.preventDefault();
    controls[(next + controls.length) % controls.length].focus();
  });
}

/**
 * Append children in the form that `h` takes.
 *
 * @param {Element} element
 * @param {Children[]} children
 */
export function append(element, children) {
  for (const child of children.flat()) {
    if (child === null || child === undefined || child === false) continue;
    element.append(child instanceof Node ? child : String(child));
  }
}

/**
 * Replace all children.
 *
 * @param {Element} element
 * @param {...Children} children
 */
export function fill(element, ...children) {
  element.replaceChildren();
  append(element, children);
}

/**
 * Set the text of an element if it changes.
 *
 * @param {Element} element
 * @param {string|number} text
 */
export function setText(element, text) {
  const value = String(text);
  if (element.textContent !== value) element.textContent = value;
}

/**
 * Make the children of an element match a list. Elements of remaining items are kept, and with them focus, hover and
 * scroll position.
 *
 * @template T
 * @param {Element} parent
 * @param {readonly T[]} items
 * @param {(item: T) => string} key            unique
 * @param {(item: T) => HTMLElement} create
 * @param {(element: HTMLElement, item: T) => void} [update]   called for kept and for new elements
 */
export function reconcile(parent, items, key, create, update) {
  /** @type {Map<string, HTMLElement>} */ const existing = new Map();
  for (const child of parent.children) {
    const element = /** @type {HTMLElement} */ (child);
    if (element.dataset.key !== undefined) existing.set(element.dataset.key, element);
  }
  let cursor = parent.firstElementChild;
  for (const item of items) {
    const itemKey = key(item);
    let element = existing.get(itemKey);
    if (element) {
      existing.delete(itemKey);
    } else {
      element = create(item);
      element.dataset.key = itemKey;
    }
    update?.(element, item);
    if (element === cursor) cursor = cursor.nextElementSibling;
    else parent.insertBefore(element, cursor);
  }
  for (const element of existing.values()) element.remove();
}

/**
 * Return the keyboard to the picture after a mouse press in an element: after a button, Space plays instead of pressing
 * it again, and after a choice in a list, F and D step again. Focus by Tab stays.
 *
 * @param {HTMLElement} element
 */
export function returnFocusToPicture(element) {
  /** @type {EventTarget|null} */ let openedSelect = null;
  const focusPicture = () => {
    const stage = /** @type {HTMLElement|null} */ (document.querySelector('[data-keys="picture"]'));
    stage?.focus({ preventScroll: true });
    return stage !== null;
  };
  element.addEventListener('mousedown', (event) => {
    openedSelect = event.target instanceof Element ? event.target.closest('select') : null;
    if (event.target instanceof Element && event.target.closest('button') && focusPicture()) event.preventDefault();
  });
  element.addEventListener('keydown', () => {
    openedSelect = null;
  });
  element.addEventListener('change', (event) => {
    if (event.target === openedSelect) focusPicture();
    openedSelect = null;
  });
}
