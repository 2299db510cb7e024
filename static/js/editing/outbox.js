// @ts-check
/**
 * Operations that the server has not acknowledged, kept in the browser's database: they survive a reload, a crash of
 * the browser and a failed server. Each is written at once, but without a flush to the disk: flushing is so slow that a
 * reload could overtake the writes that were waiting. A power failure can therefore lose operations that neither the
 * server nor the disk has yet.
 *
 * Operations are sent in the order in which they were first put. The database numbers them across visits: a clock can
 * be set back, and an edit would then be sent before the edit that it builds on.
 *
 * @typedef {import('../types.js').Command} Command
 * @typedef {object} Pending
 * @property {string} op_id
 * @property {string} run
 * @property {string} author
 * @property {Command|{name: 'undo'|'redo', op_id: string}} command   op_id empty: the server says which operation is meant when this one is sent
 * @property {Record<string, number>} seen   revision that the person saw, of each track that the command touches
 * @property {import('../types.js').UndoTarget} [about]   the operation that an undo or redo is about
 * @property {boolean} [growing]   a box that is being moved by keys; it is sent when no key is pressed for a while
 *
 * @typedef {object} Outbox
 * @property {() => Promise<Pending[]>} all               of all runs, in order
 * @property {(run: string) => Promise<Pending[]>} load   of one run, in order
 * @property {(pending: Pending) => Promise<void>} put    an operation that is already stored keeps its place
 * @property {(op_id: string) => Promise<void>} remove
 */

const DATABASE_NAME = 'tsr-review';
const DATABASE_VERSION = 2;
const STORE_NAME = 'pending';
/** The store of version 1, which sorted by the clock. */
const OLD_STORE_NAME = 'outbox';

/**
 * @param {IDBFactory} [factory]
 * @returns {Outbox}
 */
export function createOutbox(factory = globalThis.indexedDB) {
  /** @type {Promise<IDBDatabase>|null} */
  let opened = null;
  /** Number of each operation in the database, once it has one. @type {Map<string, Promise<number>>} */
  const orderNumbers = new Map();

  /** A database that failed or was closed is opened again by the next access. */
  const resetConnection = () => (opened = null);

  function database() {
    if (opened === null) {
      opened = open(factory, resetConnection);
      opened.catch(resetConnection);
    }
    return opened;
  }

  /**
   * @template T
   * @param {IDBTransactionMode} mode
   * @param {(store: IDBObjectStore) => IDBRequest<T>} makeRequest
   * @returns {Promise<T>}
   */
  async function runTransaction(mode, makeRequest) {
    const db = await database();
    return new Promise((resolve, reject) => {
      const transaction = db.transaction(STORE_NAME, mode, { durability: 'relaxed' });
      const request = makeRequest(transaction.objectStore(STORE_NAME));
      transaction.commit(); // at once, because the page may be about to close
      transaction.oncomplete = () => resolve(request.result);
      transaction.onabort = () => reject(transaction.error);
    });
  }

  /** The number of an operation; undefined: it is not in the database. @param {string} op_id @returns {Promise<number|undefined>} */
  const orderNumber = async (op_id) => orderNumbers.get(op_id)?.catch(() => undefined);

  /** @param {Pending} pending @param {Promise<number|undefined>} orderNumber @returns {Promise<number>} */
  async function write(pending, orderNumber) {
    const order = await orderNumber;
    const key = await runTransaction('readwrite', (store) => store.put(order === undefined ? pending : { ...pending, order }));
    return /** @type {number} */ (key);
  }

  async function all() {
    const rows = /** @type {(Pending & {order: number})[]} */ (await runTransaction('readonly', (store) => store.getAll()));
    return rows.map(({ order, ...pending }) => {
      orderNumbers.set(pending.op_id, Promise.resolve(order));
      return pending;
    });
  }

  return {
    all,
    load: async (run) => (await all()).filter((one) => one.run === run),
    async put(pending) {
      const written = write(pending, orderNumber(pending.op_id));
      // a later change waits only for the first write, which assigns the number
      const first = orderNumbers.get(pending.op_id) ?? written;
      orderNumbers.set(pending.op_id, first);
      first.catch(() => orderNumbers.get(pending.op_id) === first && orderNumbers.delete(pending.op_id));
      await written;
    },
    async remove(op_id) {
      const known = orderNumber(op_id);
      orderNumbers.delete(op_id);
      const order = await known;
      if (order !== undefined) await runTransaction('readwrite', (store) => store.delete(order));
    },
  };
}

/** An outbox in memory, for tests and for browsers without a database (some private windows). @returns {Outbox} */
export function createMemoryOutbox() {
  /** In the order of the first `put`. @type {Map<string, Pending>} */
  const operations = new Map();
  return {
    all: async () => [...operations.values()],
    load: async (run) => [...operations.values()].filter((pending) => pending.run === run),
    put: async (pending) => void operations.set(pending.op_id, pending),
    remove: async (op_id) => void operations.delete(op_id),
  };
}

/**
 * @param {IDBFactory} factory
 * @param {() => void} onClosed   called when the database was closed: by the browser, or for a page of a newer version
 * @returns {Promise<IDBDatabase>}
 */
function open(factory, onClosed) {
  return new Promise((resolve, reject) => {
    const request = factory.open(DATABASE_NAME, DATABASE_VERSION);
    let wasBlocked = false;
    request.onupgradeneeded = ({ oldVersion }) => {
      const db = request.result;
      const store = db.createObjectStore(STORE_NAME, { keyPath: 'order', autoIncrement: true });
      if (oldVersion === 1) migrateVersion1(db, /** @type {IDBTransaction} */ (request.transaction).objectStore(OLD_STORE_NAME), store);
    };
    request.onsuccess = () => {
      const db = request.result;
      if (wasBlocked) {
        db.close();
        return;
      }
      db.onversionchange = () => {
        db.close();
        onClosed();
      };
      db.onclose = onClosed;
      resolve(db);
    };
    request.onerror = () => reject(request.error);
    request.onblocked = () => {
      wasBlocked = true;
      reject(new Error('Another page holds an older version of the outbox. Close it.'));
    };
  });
}

/**
 * Move everything from the store of version 1 in one transaction: if one operation cannot be moved, nothing changes.
 * @param {IDBDatabase} db
 * @param {IDBObjectStore} before
 * @param {IDBObjectStore} store
 */
function migrateVersion1(db, before, store) {
  const all = /** @type {IDBRequest<(Pending & {order: number})[]>} */ (before.getAll());
  all.onsuccess = () => {
    for (const { order: _time, ...pending } of all.result.sort((a, b) => a.order - b.order)) store.add(pending);
    db.deleteObjectStore(OLD_STORE_NAME);
  };
}
