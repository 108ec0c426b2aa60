// @ts-check
// Fields for heights and numbers: the engine reads what is typed, as the program reads its command line. What cannot be changes nothing,
// and the reason stands beside the field until it can.

/**
 * A field: its name to the engine, its inputs (two for two angles), what takes its value, the texts of the value of now, and why what was typed
 * cannot be. `version` tells a late answer from the newest.
 * @typedef {{name: string, inputs: HTMLInputElement[], take: (value: any, since: number) => void, texts: () => string[], reason: string,
 *   version: number}} Field
 */

/** Fields that wait for their answers. @type {Set<Field>} */
const fieldsInReading = new Set();
/** @type {Field[]} */
const fields = [];

/**
 * Makes a field of inputs that are on the page.
 * @param {string} name
 * @param {string[]} ids
 * @param {(value: any, since: number) => void} take
 * @param {() => string[]} texts
 */
function makeField(name, ids, take, texts) {
  /** @type {Field} */
  const field = { name, inputs: ids.map(inputById), take, texts, reason: "", version: 0 };
  fields.push(field);
  for (const input of field.inputs) {
    input.addEventListener("keydown", (event) => {
      if (event.key === "Escape") forgetField(field);
    });
  }
  return field;
}

/** A number as a field shows it: with the decimal mark of the language, and empty for none. @param {number | null} value */
const fieldText = (value) => (value === null ? "" : state.language === "de" ? String(value).replace(".", ",") : String(value));

/** What is typed; several inputs are read as the command line has them. A decimal comma is one where the page writes it. @param {Field} field */
function typedText({ inputs }) {
  const texts = inputs.map(({ value }) => (state.language === "de" ? value.trim().replace(/^([^.,]*),([^.,]*)$/, "$1.$2") : value.trim()));
  return texts.filter((text) => text).join(",");
}

/** Reads a field. @param {Field} field @param {number} [since] when the person typed */
async function readField(field, since = performance.now()) {
  field.version += 1;
  const { version } = field;
  fieldsInReading.add(field);
  // Until there is an engine, what is typed waits for it.
  if (!engine.opened) return;
  const uav = selectedUav();
  const question = { do: "read", field: field.name, text: typedText(field), x: uav.x, y: uav.y };
  /** @type {FieldAnswer} */
  const answer = await ask(question).catch((error) => ({ ok: false, words: wordsOf(error) }));
  if (version !== field.version) return;
  fieldsInReading.delete(field);
  if (!answer.ok) tellReason(field, "height" in answer ? failureWords(uav, answer, answer.height) : answer.words);
  else {
    tellReason(field, "");
    field.take(answer.value, since);
  }
  settle();
}

/** Shows the value of now in a field, unless what stands there waits for its answer or was refused. @param {Field} field */
function showField(field) {
  if (field.reason || fieldsInReading.has(field)) return;
  field.texts().forEach((text, k) => setValue(field.inputs[k], text));
}

/** Shows the value of now in place of what was typed. @param {Field} field */
function forgetField(field) {
  field.version += 1;
  fieldsInReading.delete(field);
  tellReason(field, "");
  field.texts().forEach((text, k) => {
    field.inputs[k].value = text;
  });
}

/** Says below a field why what was typed cannot be. @param {Field} field @param {string} reason */
function tellReason(field, reason) {
  field.reason = reason;
  const [first] = field.inputs;
  const id = `${first.id}-reason`;
  const words = document.getElementById(id) ?? make("p", { id, class: "reason", role: "alert" });
  if (!words.isConnected) first.closest(".row")?.after(words);
  setText(words, reason);
  words.hidden = !reason;
  for (const input of field.inputs) {
    if (reason) for (const [name, value] of [["aria-invalid", "true"], ["aria-describedby", id]]) input.setAttribute(name, value);
    else for (const name of ["aria-invalid", "aria-describedby"]) input.removeAttribute(name);
  }
}
