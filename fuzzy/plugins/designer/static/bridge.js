// A NiceGUI component that shows an ES module in anywidget's form: render({ model, el }), over NiceGUI's socket.
// What Python sends arrives through receive() and receiveMessage(); what the module says leaves as events.

/** The module's model. Values are replaced whole; nothing here is reactive, so that large surfaces cost nothing. */
function makeModel(values, emit) {
  const listeners = new Map(); // event -> set of functions
  const tell = (event, ...details) => {
    for (const listener of [...(listeners.get(event) ?? [])]) listener(...details);
  };
  return {
    get: (name) => values[name],
    on(events, listener) {
      for (const event of events.split(" ")) {
        if (!listeners.has(event)) listeners.set(event, new Set());
        listeners.get(event).add(listener);
      }
    },
    off(events, listener) {
      if (!events) listeners.clear();
      else
        for (const event of events.split(" "))
          listener ? listeners.get(event)?.delete(listener) : listeners.delete(event);
    },
    send: (content) => emit("message", content),
    widget_manager: null,
    // Not for modules: what Python sends. All values are in place before the first listener looks.
    receive(news) {
      Object.assign(values, news);
      for (const [name, value] of Object.entries(news)) tell(`change:${name}`, { new: value });
      tell("change");
    },
    receiveMessage: (content) => tell("msg:custom", content, []),
  };
}

export default {
  template: "<div></div>",
  props: { module: String, traits: String },
  created() {
    // Made here and not in data(): Vue then leaves it alone.
    this.model = makeModel(JSON.parse(this.traits), (event, value) => this.$emit(event, value));
    this.gone = false;
    this.early = []; // messages that came before the module could hear them
  },
  async mounted() {
    const el = this.$el;
    try {
      const module = await import(this.module);
      if (this.gone) return;
      const render = module.default?.render ?? module.render;
      const cleanUp = await render({ model: this.model, el });
      if (this.gone) cleanUp?.();
      else this.cleanUp = cleanUp;
      for (const content of this.early.splice(0)) this.model.receiveMessage(content);
      el.dataset.ready = "";
    } catch (error) {
      console.error(error);
      el.textContent = `This part of the page could not be loaded: ${error.message ?? error}`;
    }
  },
  unmounted() {
    this.gone = true;
    this.cleanUp?.();
  },
  methods: {
    receive(news) {
      this.model.receive(news);
    },
    receiveMessage(content) {
      if ("ready" in this.$el.dataset) this.model.receiveMessage(content);
      else this.early.push(content);
    },
  },
};
