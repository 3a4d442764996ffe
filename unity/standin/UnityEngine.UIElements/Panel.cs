// What shows elements where there is no window: places them roughly, sends them events, keeps time, and has them drawn.
using System;
using System.Collections.Generic;
using System.Linq;
using UnityEngine;
using UnityEngine.UIElements;

namespace StandIn
{
    public sealed class Panel : IPanel
    {
        readonly Dictionary<VisualElement, List<Shape>> drawn = new Dictionary<VisualElement, List<Shape>>();
        internal readonly List<ScheduledItem> scheduled = new List<ScheduledItem>();
        internal VisualElement captor;
        internal bool needsLayout = true;
        readonly Queue<(EventBase, VisualElement)> waiting = new Queue<(EventBase, VisualElement)>();
        bool isDispatching;
        VisualElement under, down;
        Vector2 pointer;
        int pressed;

        public Panel(VisualElement root, float width, float height)
        {
            visualTree = root;
            Size = new Vector2(width, height);
            Attach(root);
            Update();
        }

        public VisualElement visualTree { get; }
        public FocusController focusController { get; } = new FocusController();
        public Vector2 Size { get; private set; }
        public long Milliseconds { get; private set; }

        /// Places and draws what changed.
        public void Update()
        {
            // Styles change without a word; whoever hears of a new size may change more.
            needsLayout = true;
            for (var i = 0; needsLayout && i < 8; i++)
            {
                needsLayout = false;
                Place(visualTree, new Rect(0, 0, Size.x, Size.y));
            }
            foreach (var element in All(visualTree).Where(IsShown))
                if (element.isDirty && element.generateVisualContent != null)
                {
                    element.isDirty = false;
                    var context = new MeshGenerationContext(element);
                    element.generateVisualContent(context);
                    context.Finish();
                    drawn[element] = context.shapes;
                }
        }

        public void Resize(float width, float height)
        {
            Size = new Vector2(width, height);
            needsLayout = true;
            Update();
        }

        /// What an element drew last.
        public IReadOnlyList<Shape> DrawnBy(VisualElement element) => drawn.TryGetValue(element, out var shapes) ? shapes : new List<Shape>();

        /// Lets time pass; what is scheduled meanwhile runs.
        public void Advance(long milliseconds)
        {
            var end = Milliseconds + milliseconds;
            while (true)
            {
                var next = scheduled.Where(item => item.isActive && item.At <= end).OrderBy(item => item.At).FirstOrDefault();
                if (next == null) break;
                Milliseconds = Math.Max(Milliseconds, next.At);
                next.Run();
            }
            Milliseconds = end;
            Update();
        }

        public void PointerDown(Vector2 at, int button = 0, int clicks = 1, EventModifiers modifiers = EventModifiers.None, string type = "mouse")
        {
            PointerMove(at, modifiers, type);
            pressed |= 1 << button;
            var target = Target(at);
            for (var focus = target; focus != null; focus = focus.hierarchy.parent)
                if (focus.canGrabFocus) { Focus(focus); break; }
            down = target;
            Dispatch(new PointerDownEvent { position = at, button = button, pressedButtons = pressed, clickCount = clicks, modifiers = modifiers, pointerType = type }, target);
            Update();
        }

        public void PointerMove(Vector2 at, EventModifiers modifiers = EventModifiers.None, string type = "mouse")
        {
            var by = at - pointer;
            pointer = at;
            var over = Pick(at);
            if (over != under)
            {
                for (var left = under; left != null; left = left.hierarchy.parent)
                    if (over == null || left != over && !left.Contains(over)) Dispatch(new PointerLeaveEvent { position = at }, left);
                for (var entered = over; entered != null; entered = entered.hierarchy.parent)
                    if (under == null || entered != under && !entered.Contains(under)) Dispatch(new PointerEnterEvent { position = at }, entered);
                under = over;
            }
            Dispatch(new PointerMoveEvent { position = at, deltaPosition = by, button = -1, pressedButtons = pressed, modifiers = modifiers, pointerType = type }, Target(at));
            Update();
        }

        public void PointerUp(Vector2 at, int button = 0, EventModifiers modifiers = EventModifiers.None, string type = "mouse")
        {
            PointerMove(at, modifiers, type);
            pressed &= ~(1 << button);
            var target = Target(at);
            Dispatch(new PointerUpEvent { position = at, button = button, pressedButtons = pressed, modifiers = modifiers, pointerType = type }, target);
            // What lies under the pointer then and now is clicked.
            var clicked = Pick(at);
            while (clicked != null && clicked != down && !clicked.Contains(down)) clicked = clicked.hierarchy.parent;
            if (button == 0 && clicked != null) Dispatch(new ClickEvent { position = at, modifiers = modifiers }, clicked);
            Update();
        }

        public void Click(Vector2 at, int button = 0, int clicks = 1, EventModifiers modifiers = EventModifiers.None)
        {
            PointerDown(at, button, clicks, modifiers);
            PointerUp(at, button, modifiers);
        }

        public void Wheel(Vector2 at, float delta, EventModifiers modifiers = EventModifiers.None)
        {
            Dispatch(new WheelEvent { mousePosition = at, delta = new Vector3(0, delta, 0), modifiers = modifiers }, Target(at));
            Update();
        }

        /// A key; arrow keys also move the focus unless that is ignored. Returns whether the focus would have moved.
        public bool Key(KeyCode key, EventModifiers modifiers = EventModifiers.None)
        {
            var target = focusController.focusedElement as VisualElement ?? visualTree;
            Dispatch(KeyDownEvent.GetPooled('\0', key, modifiers), target);
            var moves = false;
            if (key >= KeyCode.UpArrow && key <= KeyCode.LeftArrow)
            {
                var direction = key == KeyCode.UpArrow ? NavigationMoveEvent.Direction.Up : key == KeyCode.DownArrow ? NavigationMoveEvent.Direction.Down
                    : key == KeyCode.RightArrow ? NavigationMoveEvent.Direction.Right : NavigationMoveEvent.Direction.Left;
                var move = new NavigationMoveEvent { direction = direction };
                Dispatch(move, target);
                moves = !move.isDefaultPrevented;
            }
            Update();
            return moves;
        }

        public void Focus(VisualElement element)
        {
            var before = focusController.focusedElement as VisualElement;
            if (before == element) return;
            focusController.focusedElement = element;
            if (before != null) { Send(new FocusOutEvent(), before); Send(new BlurEvent(), before); }
            if (element != null) { Send(new FocusInEvent(), element); Send(new FocusEvent(), element); }
        }

        /// The topmost element at a place that takes events.
        public VisualElement Pick(Vector2 at) => Pick(visualTree, at);

        VisualElement Target(Vector2 at) => captor ?? Pick(at) ?? visualTree;

        static VisualElement Pick(VisualElement element, Vector2 at)
        {
            if (element.style.display.value == DisplayStyle.None || !element.visible) return null;
            var isIn = element.ContainsPoint(at - element.worldBound.position);
            if (!isIn && element.style.overflow.value == Overflow.Hidden) return null;
            foreach (var child in element.hierarchy.Children().Reverse())
            {
                var found = Pick(child, at);
                if (found != null) return found;
            }
            return isIn && element.pickingMode == PickingMode.Position ? element : null;
        }

        internal void Capture(VisualElement element, int pointerId)
        {
            var before = captor;
            captor = element;
            if (before != null && before != element) Send(new PointerCaptureOutEvent { pointerId = pointerId }, before);
        }

        /// Takes the pointer away, as another window does.
        public void LoseCapture() => Capture(null, 0);

        /// What is sent while another event is on its way waits for the end of that.
        internal void Send(EventBase e, VisualElement target)
        {
            if (isDispatching) waiting.Enqueue((e, target));
            else Dispatch(e, target);
        }

        internal void Dispatch(EventBase e, VisualElement target)
        {
            var isOuter = !isDispatching;
            isDispatching = true;
            try
            {
                Deliver(e, target);
                while (isOuter && waiting.Count > 0)
                {
                    var (next, of) = waiting.Dequeue();
                    Deliver(next, of);
                }
            }
            finally
            {
                if (isOuter) isDispatching = false;
            }
        }

        void Deliver(EventBase e, VisualElement target)
        {
            // What is disabled hears of nothing that a person does.
            if (!target.enabledInHierarchy && (e is IPointerEvent || e is KeyDownEvent || e is WheelEvent)) return;
            e.target = target;
            e.timestamp = Milliseconds;
            var above = new List<VisualElement>();
            for (var at = target.hierarchy.parent; at != null; at = at.hierarchy.parent) above.Add(at);
            if (e.tricklesDown)
                for (var i = above.Count - 1; i >= 0 && !e.isPropagationStopped; i--)
                {
                    e.propagationPhase = PropagationPhase.TrickleDown;
                    above[i].Call(e, true, false);
                }
            if (!e.isPropagationStopped)
            {
                e.propagationPhase = PropagationPhase.AtTarget;
                target.Call(e, true, true);
            }
            if (e.bubbles)
                for (var i = 0; i < above.Count && !e.isPropagationStopped; i++)
                {
                    e.propagationPhase = PropagationPhase.BubbleUp;
                    above[i].Call(e, false, false);
                }
        }

        internal void Attach(VisualElement element)
        {
            element.ownPanel = this;
            element.isDirty = true;
            Dispatch(new AttachToPanelEvent { destinationPanel = this }, element);
            foreach (var child in element.hierarchy.Children().ToList()) Attach(child);
        }

        internal void Detach(VisualElement element)
        {
            foreach (var child in element.hierarchy.Children().ToList()) Detach(child);
            if (captor == element) Capture(null, 0);
            if (focusController.focusedElement == element) Focus(null);
            Dispatch(new DetachFromPanelEvent { originPanel = this }, element);
            element.ownPanel = null;
            drawn.Remove(element);
        }

        public static IEnumerable<VisualElement> All(VisualElement element) => new[] { element }.Concat(element.hierarchy.Children().ToList().SelectMany(All));

        internal static bool IsShown(VisualElement element)
        {
            for (var at = element; at != null; at = at.hierarchy.parent) if (at.style.display.value == DisplayStyle.None) return false;
            return true;
        }

        /// Rows and columns with fixed, relative and growing lengths; enough for events to arrive where they should.
        void Place(VisualElement element, Rect at)
        {
            var before = element.layout;
            element.layout = at;
            if (before.width != at.width || before.height != at.height)
            {
                element.isDirty = true;
                if (IsShown(element)) Dispatch(new GeometryChangedEvent { oldRect = before, newRect = at }, element);
            }
            var row = element.style.flexDirection.value == FlexDirection.Row;
            var flowing = element.hierarchy.Children().Where(child => child.style.display.value != DisplayStyle.None && child.style.position.value != Position.Absolute).ToList();
            var available = row ? at.width : at.height;
            var fixedLength = flowing.Where(child => child.style.flexGrow.value == 0).Sum(child => Extent(child, row, available));
            var growing = flowing.Sum(child => child.style.flexGrow.value);
            float place = 0;
            foreach (var child in flowing)
            {
                var grow = child.style.flexGrow.value;
                var length = grow > 0 ? Math.Max(Extent(child, row, available, true), (available - fixedLength) * grow / growing) : Extent(child, row, available);
                var across = row ? child.style.height : child.style.width;
                var width = across.IsPixels ? across.value.value : row ? at.height : at.width;
                Place(child, row ? new Rect(place, 0, length, width) : new Rect(0, place, width, length));
                place += length;
            }
            foreach (var child in element.hierarchy.Children().Where(child => child.style.position.value == Position.Absolute))
            {
                float Of(StyleLength length, float whole, float otherwise) => length.IsPixels ? length.value.value : length.IsPercent ? length.value.value * whole / 100 : otherwise;
                float left = Of(child.style.left, at.width, 0), top = Of(child.style.top, at.height, 0);
                var width = Of(child.style.width, at.width, child.style.right.IsPixels ? at.width - left - child.style.right.value.value : Extent(child, true, at.width));
                var height = Of(child.style.height, at.height, child.style.bottom.IsPixels ? at.height - top - child.style.bottom.value.value : Extent(child, false, at.height));
                Place(child, new Rect(left, top, width, height));
            }
        }

        static float Extent(VisualElement element, bool across, float available, bool least = false)
        {
            var length = across ? element.style.width : element.style.height;
            var minimum = across ? element.style.minWidth : element.style.minHeight;
            if (length.IsPixels) return length.value.value;
            if (length.IsPercent) return length.value.value * available / 100;
            if (least) return minimum.IsPixels ? minimum.value.value : 0;
            var row = element.style.flexDirection.value == FlexDirection.Row;
            var children = element.hierarchy.Children().Where(child => child.style.display.value != DisplayStyle.None && child.style.position.value != Position.Absolute)
                .Select(child => Extent(child, across, available)).DefaultIfEmpty(across ? 60 : 18);
            return Math.Max(row == across ? children.Sum() : children.Max(), minimum.IsPixels ? minimum.value.value : 0);
        }
    }

    sealed class Scheduler : IVisualElementScheduler
    {
        readonly VisualElement element;
        public Scheduler(VisualElement element) { this.element = element; }
        public IVisualElementScheduledItem Execute(Action updateEvent)
        {
            var item = new ScheduledItem(element, updateEvent);
            item.Resume();
            return item;
        }
    }

    sealed class ScheduledItem : IVisualElementScheduledItem
    {
        readonly VisualElement element;
        readonly Action action;
        long delay, interval;
        bool repeats;
        Func<bool> stop;
        Panel panel;

        public ScheduledItem(VisualElement element, Action action)
        {
            this.element = element;
            this.action = action;
            // As in Unity, what is scheduled waits while its element is in no panel.
            element.RegisterCallback<AttachToPanelEvent>(_ => { if (isActive) Resume(); });
            element.RegisterCallback<DetachFromPanelEvent>(_ => { panel?.scheduled.Remove(this); panel = null; });
        }

        public bool isActive { get; private set; }
        internal long At { get; private set; }

        internal void Run()
        {
            if (repeats && (stop == null || !stop())) At = panel.Milliseconds + Math.Max(interval, 1);
            else Pause();
            action();
        }

        public void Resume()
        {
            isActive = true;
            if (element.ownPanel == null) return;
            panel = element.ownPanel;
            At = panel.Milliseconds + delay;
            if (!panel.scheduled.Contains(this)) panel.scheduled.Add(this);
        }

        public void Pause()
        {
            isActive = false;
            panel?.scheduled.Remove(this);
        }

        public void ExecuteLater(long delayMs) { delay = delayMs; Resume(); }
        public IVisualElementScheduledItem StartingIn(long delayMs) { delay = delayMs; Resume(); return this; }
        public IVisualElementScheduledItem Every(long intervalMs) { interval = intervalMs; repeats = true; return this; }
        public IVisualElementScheduledItem Until(Func<bool> stopCondition) { stop = stopCondition; return this; }
    }
}
