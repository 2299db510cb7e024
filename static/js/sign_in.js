// @ts-check
/**
 * The page where people sign in. The token of a link stands behind `#`, which browsers send to nobody; an address of the
 * review tool there is where one goes on afterwards.
 */

import { sentence } from './api/errors.js';
import { createSend, readJson } from './api/http.js';

const send = createSend({ base: '/api', fetch: globalThis.fetch.bind(globalThis) });
const form = /** @type {HTMLFormElement} */ (document.getElementById('sign-in'));
const field = /** @type {HTMLInputElement} */ (document.getElementById('token'));
const problem = /** @type {HTMLElement} */ (document.getElementById('problem'));
const said = location.hash.slice(1);
const place = said.startsWith('/') ? `#${said}` : '';

const goOn = () => location.replace(`/${place}`);

/** @param {string} token */
async function signIn(token) {
  problem.textContent = '';
  try {
    await readJson(await send('/session', { method: 'POST', body: { token } }));
    goOn();
  } catch (thrown) {
    problem.textContent = sentence(thrown);
    field.focus();
    field.select();
  }
}

form.addEventListener('submit', (event) => {
  event.preventDefault();
  void signIn(field.value.trim());
});
// before that the browser would send the form itself, with the token in the address
/** @type {HTMLButtonElement} */ (form.querySelector('button')).disabled = false;

if (said !== '' && place === '') {
  history.replaceState(null, '', '/sign-in'); // neither the address nor the history keeps the token
  field.value = said;
  void signIn(said);
} else {
  // who is signed in already, as after a link from elsewhere, goes on
  send('/session').then(goOn, () => {});
}
