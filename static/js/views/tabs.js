// @ts-check
/** Tabs as the ARIA practices have them: arrows move, Home and End jump; only the open panel is updated. */

import {h} from './dom.js';
import {recall, remember} from './preferences.js';

/**
 * @param {object} options
 * @param {string} options.label
 * @param {string} options.name    under which the open tab is remembered
 * @param {{id: string, label: string, view: import('../page-types.js').View}[]} options.tabs
 * @returns {import('../page-types.js').View & {open: (id: string) => void}}
 */
export function createTabs({label, name, tabs}) {
  let open = tabs.find(({id}) => id === recall(name))?.id ?? tabs[0].id;
  /** @type {import('../state-types.js').State|null} */
  let last = null;
  const buttons = tabs.map((tab) => h('button', {
    class: 'tab', type: 'button', role: 'tab', id: `tab-${tab.id}`, 'aria-controls': `panel-${tab.id}`, onclick: (/** @type {MouseEvent} */ event) => {
      show(tab.id);
      // a click of the mouse leaves the keys to the picture; who came by keyboard goes on from here
      if (event.detail > 0) buttons.forEach((button) => button.blur());
    },
  }, tab.label));
  const panels = tabs.map((tab) => h('div', {
    class: 'tab-panel', role: 'tabpanel', id: `panel-${tab.id}`, 'aria-labelledby': `tab-${tab.id}`,
  }, tab.view.element));
  const list = h('div', {class: 'tab-list', role: 'tablist', 'aria-label': label}, ...buttons);
  const element = h('div', {class: 'tabs'}, list, ...panels);

  list.addEventListener('keydown', (event) => {
    const at = tabs.findIndex(({id}) => id === open);
    const next = event.key === 'ArrowRight' ? at + 1 : event.key === 'ArrowLeft' ? at - 1 : event.key === 'Home' ? 0 : event.key === 'End' ? tabs.length - 1 : null;
    if (next === null || event.altKey) return;
    event.preventDefault();
    event.stopPropagation();
    const place = (next + tabs.length) % tabs.length;
    show(tabs[place].id);
    buttons[place].focus();
  });

  /** @param {string} id */
  function show(id) {
    open = id;
    remember(name, id);
    tabs.forEach((tab, at) => {
      const on = tab.id === open;
      buttons[at].setAttribute('aria-selected', String(on));
      buttons[at].tabIndex = on ? 0 : -1;
      panels[at].hidden = !on;
      if (on && last) tab.view.update(last);
    });
  }
  show(open);

  return {
    element,
    open: show,
    update(state) {
      last = state;
      tabs.find(({id}) => id === open)?.view.update(state);
    },
    destroy: () => tabs.forEach(({view}) => view.destroy()),
  };
}
