// @ts-check
/**
 * Operations that the server has not acknowledged yet, kept in the browser's database: a reload, a crash of the browser
 * or a dead server loses none of them. Each is written at once, but not forced to the disk: that takes so long that a
 * reload overtook those that were waiting. What the machine's power takes along is what neither server nor disk had yet.
 *
 * They come back in the order in which they were first put. The database counts that, also over several visits: a clock
 * can be set back, and what builds on an edit would then be sent before it.
 *
 * @typedef {import('../types.js').Command} Command
 * @typedef {object} Pending
 * @property {string} op_id
 * @property {string} run
 * @property {string} author
 * @property {Command|{name: 'undo'|'redo', op_id: string}} command   op_id empty: of what, the server says when its turn comes
 * @property {Record<string, number>} seen   revision of each touched track that the person saw
 * @property {import('../types.js').UndoTarget} [about]   of an undo or redo: the operation that it is about
 * @property {boolean} [growing]   a box that is being moved by keys: it is sent when they rest
 *
 * @typedef {object} Outbox
 * @property {() => Promise<Pending[]>} all               of all runs, in order
 * @property {(run: string) => Promise<Pending[]>} load   of one run, in order
 * @property {(pending: Pending) => Promise<void>} put    one that is there already keeps its place
 * @property {(op_id: string) => Promise<void>} remove
 */

const NAME = 'tsr-review';
const VERSION = 2;
const STORE = 'pending';
/** Of version 1, which ordered by the clock. */
const BEFORE = 'outbox';

/**
 * @param {IDBFactory} [factory]
 * @returns {Outbox}
 */
export function createOutbox(factory = globalThis.indexedDB) {
  /** @type {Promise<IDBDatabase>|null} */
  let opened = null;
  /** Number of each operation in the database, once it has one. @type {Map<string, Promise<number>>} */
  const places = new Map();

  /** What failed or was closed is opened anew by the next who needs it. */
  const forget = () => (opened = null);

  function database() {
    if (opened === null) {
      opened = open(factory, forget);
      opened.catch(forget);
    }
    return opened;
  }

  /**
   * @template T
   * @param {IDBTransactionMode} mode
   * @param {(store: IDBObjectStore) => IDBRequest<T>} act
   * @returns {Promise<T>}
   */
  async function within(mode, act) {
    const db = await database();
    return new Promise((resolve, reject) => {
      const transaction = db.transaction(STORE, mode, { durability: 'relaxed' });
      const request = act(transaction.objectStore(STORE));
      transaction.commit(); // not only when the page comes round to it: it may be about to go
      transaction.oncomplete = () => resolve(request.result);
      transaction.onabort = () => reject(transaction.error);
    });
  }

  /** Undefined: it is not in the database. @param {string} op_id @returns {Promise<number|undefined>} */
  const placeOf = async (op_id) => places.get(op_id)?.catch(() => undefined);

  /** @param {Pending} pending @param {Promise<number|undefined>} place @returns {Promise<number>} */
  async function write(pending, place) {
    const order = await place;
    const key = await within('readwrite', (store) => store.put(order === undefined ? pending : { ...pending, order }));
    return /** @type {number} */ (key);
  }

  async function all() {
    const rows = /** @type {(Pending & {order: number})[]} */ (await within('readonly', (store) => store.getAll()));
    return rows.map(({ order, ...pending }) => {
      places.set(pending.op_id, Promise.resolve(order));
      return pending;
    });
  }

  return {
    all,
    load: async (run) => (await all()).filter((one) => one.run === run),
    async put(pending) {
      const written = write(pending, placeOf(pending.op_id));
      // what is changed later waits for the first writing alone, which gives it its place
      const first = places.get(pending.op_id) ?? written;
      places.set(pending.op_id, first);
      first.catch(() => places.get(pending.op_id) === first && places.delete(pending.op_id));
      await written;
    },
    async remove(op_id) {
      const place = placeOf(op_id);
      places.delete(op_id);
      const order = await place;
      if (order !== undefined) await within('readwrite', (store) => store.delete(order));
    },
  };
}

/** An outbox in memory, where the browser has no database (private windows of some) and in tests. @returns {Outbox} */
export function createMemoryOutbox() {
  /** In the order of the first `put`. @type {Map<string, Pending>} */
  const held = new Map();
  return {
    all: async () => [...held.values()],
    load: async (run) => [...held.values()].filter((pending) => pending.run === run),
    put: async (pending) => void held.set(pending.op_id, pending),
    remove: async (op_id) => void held.delete(op_id),
  };
}

/**
 * @param {IDBFactory} factory
 * @param {() => void} closed   the database was closed: by the browser, or for a page of a newer version
 * @returns {Promise<IDBDatabase>}
 */
function open(factory, closed) {
  return new Promise((resolve, reject) => {
    const request = factory.open(NAME, VERSION);
    let late = false;
    request.onupgradeneeded = ({ oldVersion }) => {
      const db = request.result;
      const store = db.createObjectStore(STORE, { keyPath: 'order', autoIncrement: true });
      if (oldVersion === 1) takeOver(db, /** @type {IDBTransaction} */ (request.transaction).objectStore(BEFORE), store);
    };
    request.onsuccess = () => {
      const db = request.result;
      if (late) {
        db.close();
        return;
      }
      db.onversionchange = () => {
        db.close();
        closed();
      };
      db.onclose = closed;
      resolve(db);
    };
    request.onerror = () => reject(request.error);
    request.onblocked = () => {
      late = true;
      reject(new Error('Another page holds an older version of the outbox. Close it.'));
    };
  });
}

/**
 * Everything that version 1 holds, in the same transaction: if one of them cannot be taken over, all stays as it was.
 * @param {IDBDatabase} db
 * @param {IDBObjectStore} before
 * @param {IDBObjectStore} store
 */
function takeOver(db, before, store) {
  const all = /** @type {IDBRequest<(Pending & {order: number})[]>} */ (before.getAll());
  all.onsuccess = () => {
    for (const { order: _time, ...pending } of all.result.sort((a, b) => a.order - b.order)) store.add(pending);
    db.deleteObjectStore(BEFORE);
  };
}
