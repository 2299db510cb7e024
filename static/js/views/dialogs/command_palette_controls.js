// @ts-check
/** Controls of the screen besides the operations: buttons, links, choices and fields, by their names on the screen. */

const CONTROLS = 'button, a[href], select, summary, input';
/** Controls to skip: operations have their own entries, and options belong to their list. */
const SKIPPED = '[data-operation], [role=option], [aria-hidden=true], dialog';

/** @typedef {HTMLButtonElement|HTMLAnchorElement|HTMLSelectElement|HTMLInputElement} Control */

/**
 * @param {Element} root
 * @param {string} screen   the heading for controls without one
 * @returns {{text: string, also: string, kind: string, reason: string|null, run: () => void}[]} controls with a name, in screen order
 */
export function controlsOf(root, screen) {
  const controls = /** @type {Control[]} */ ([...root.querySelectorAll(CONTROLS)]);
  return controls
    .filter((control) => control.closest(SKIPPED) === null && control.checkVisibility({ visibilityProperty: true }))
    .flatMap((element) => {
      const name = nameOf(element);
      if (name === '') return [];
      const common = {
        also: element.title,
        kind: headingOf(element, root) || screen,
        reason: element.matches(':disabled, [aria-disabled=true]') ? element.title || 'This is not possible now.' : null,
      };
      if (!(element instanceof HTMLSelectElement)) return [{ ...common, text: name, run: () => activate(element) }];
      return [...element.options]
        .filter(({ disabled }) => !disabled)
        .map((option) => ({ ...common, text: `${name}: ${option.text}`, run: () => choose(element, option.value) }));
    });
}

/** @param {Control} element */
function nameOf(element) {
  const labels = 'labels' in element && element.labels?.length ? [...element.labels].map(textOf).join(' ') : '';
  return (element.getAttribute('aria-label') || labels || textOf(element) || element.title).trim().slice(0, 200);
}

/** @param {Element} element */
const textOf = (element) => (element instanceof HTMLElement ? element.innerText : (element.textContent ?? '')).replace(/\s+/g, ' ').trim();

/** The heading of an element: the nearest one around it. @param {Element} element @param {Element} root */
function headingOf(element, root) {
  for (let ancestor = element.parentElement; ancestor !== null && ancestor !== root; ancestor = ancestor.parentElement) {
    const heading = ancestor.querySelector('h1, h2, h3, h4');
    if (heading) return textOf(heading).slice(0, 100);
  }
  return '';
}

/** Press a button or link; focus a field. @param {Exclude<Control, HTMLSelectElement>} element */
function activate(element) {
  element.scrollIntoView({ block: 'nearest' });
  element.focus();
  if (!(element instanceof HTMLInputElement) || ['checkbox', 'radio', 'file', 'button'].includes(element.type)) element.click();
}

/** @param {HTMLSelectElement} element @param {string} value */
function choose(element, value) {
  element.value = value;
  element.dispatchEvent(new Event('input', { bubbles: true }));
  element.dispatchEvent(new Event('change', { bubbles: true }));
}
