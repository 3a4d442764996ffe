// Events of UI Toolkit: their fields, and how they trickle down and bubble up.
using System;
using System.Collections.Generic;

namespace UnityEngine.UIElements
{
    public enum TrickleDown { NoTrickleDown, TrickleDown }
    public enum PropagationPhase { None, TrickleDown, BubbleUp, AtTarget }
    public interface IEventHandler { void SendEvent(EventBase e); }

    public abstract class EventBase : IDisposable
    {
        public IEventHandler target { get; set; }
        public IEventHandler currentTarget { get; internal set; }
        public PropagationPhase propagationPhase { get; internal set; }
        public bool bubbles { get; protected set; } = true;
        public bool tricklesDown { get; protected set; } = true;
        public bool isPropagationStopped { get; private set; }
        public bool isImmediatePropagationStopped { get; private set; }
        public bool isDefaultPrevented { get; private set; }
        public long timestamp { get; internal set; }
        public void StopPropagation() => isPropagationStopped = true;
        public void StopImmediatePropagation() { isPropagationStopped = true; isImmediatePropagationStopped = true; }
#if UNITY_6000_0_OR_NEWER
        [Obsolete("Use StopPropagation and/or FocusController.IgnoreEvent instead.")]
#endif
        public void PreventDefault() => isDefaultPrevented = true;
        internal void Ignore() => isDefaultPrevented = true;
        public void Dispose() { }
    }

    public abstract class EventBase<T> : EventBase where T : EventBase<T>, new()
    {
        public static T GetPooled() => new T();
    }

    public delegate void EventCallback<in TEventType>(TEventType evt);

    public interface IPointerEvent
    {
        int pointerId { get; }
        Vector3 position { get; }
        Vector3 localPosition { get; }
        int button { get; }
        int pressedButtons { get; }
        int clickCount { get; }
    }

    public static class PointerId
    {
        public static readonly int mousePointerId = 0;
        public static readonly int touchPointerIdBase = 1;
    }

    public static class PointerType
    {
        public static readonly string mouse = "mouse";
        public static readonly string touch = "touch";
    }

    public abstract class PointerEventBase<T> : EventBase<T>, IPointerEvent where T : PointerEventBase<T>, new()
    {
        public int pointerId { get; protected internal set; }
        public string pointerType { get; protected internal set; } = "mouse";
        public bool isPrimary { get; protected internal set; } = true;
        public int button { get; protected internal set; }
        public int pressedButtons { get; protected internal set; }
        public Vector3 position { get; protected internal set; }
        public Vector3 deltaPosition { get; protected internal set; }
        public int clickCount { get; protected internal set; }
        public EventModifiers modifiers { get; protected internal set; }
        public bool shiftKey => (modifiers & EventModifiers.Shift) != 0;
        public bool ctrlKey => (modifiers & EventModifiers.Control) != 0;
        public bool commandKey => (modifiers & EventModifiers.Command) != 0;
        public bool altKey => (modifiers & EventModifiers.Alt) != 0;
        public bool actionKey => ctrlKey;
        public Vector3 localPosition
        {
            get
            {
                var origin = ((currentTarget ?? target) as VisualElement)?.worldBound.position ?? default;
                return new Vector3(position.x - origin.x, position.y - origin.y, 0);
            }
        }
    }

    public sealed class PointerDownEvent : PointerEventBase<PointerDownEvent> { }
    public sealed class PointerMoveEvent : PointerEventBase<PointerMoveEvent> { }
    public sealed class PointerUpEvent : PointerEventBase<PointerUpEvent> { }
    public sealed class PointerCancelEvent : PointerEventBase<PointerCancelEvent> { }
    public sealed class PointerEnterEvent : PointerEventBase<PointerEnterEvent> { public PointerEnterEvent() { bubbles = false; } }
    public sealed class PointerLeaveEvent : PointerEventBase<PointerLeaveEvent> { public PointerLeaveEvent() { bubbles = false; } }
    public sealed class ClickEvent : PointerEventBase<ClickEvent> { }
    public sealed class PointerCaptureOutEvent : EventBase<PointerCaptureOutEvent> { public int pointerId { get; internal set; } }

    public sealed class WheelEvent : EventBase<WheelEvent>
    {
        public Vector3 delta { get; internal set; }
        public Vector2 mousePosition { get; internal set; }
        public EventModifiers modifiers { get; internal set; }
        public bool shiftKey => (modifiers & EventModifiers.Shift) != 0;
        public bool ctrlKey => (modifiers & EventModifiers.Control) != 0;
        public Vector2 localMousePosition => mousePosition - (((currentTarget ?? target) as VisualElement)?.worldBound.position ?? default);
    }

    public abstract class KeyboardEventBase<T> : EventBase<T> where T : KeyboardEventBase<T>, new()
    {
        public EventModifiers modifiers { get; protected internal set; }
        public char character { get; protected internal set; }
        public KeyCode keyCode { get; protected internal set; }
        public bool shiftKey => (modifiers & EventModifiers.Shift) != 0;
        public bool ctrlKey => (modifiers & EventModifiers.Control) != 0;
        public bool commandKey => (modifiers & EventModifiers.Command) != 0;
        public bool altKey => (modifiers & EventModifiers.Alt) != 0;
        public bool actionKey => ctrlKey;
    }

    public sealed class KeyDownEvent : KeyboardEventBase<KeyDownEvent>
    {
        public static KeyDownEvent GetPooled(char c, KeyCode keyCode, EventModifiers modifiers) => new KeyDownEvent { character = c, keyCode = keyCode, modifiers = modifiers };
    }

    public sealed class KeyUpEvent : KeyboardEventBase<KeyUpEvent> { }

    /// What the arrow keys also are: it moves the focus unless it is ignored.
    public sealed class NavigationMoveEvent : EventBase<NavigationMoveEvent>
    {
        public enum Direction { None, Left, Up, Right, Down, Next, Previous }
        public Direction direction { get; internal set; }
    }

    public sealed class GeometryChangedEvent : EventBase<GeometryChangedEvent>
    {
        public Rect oldRect { get; internal set; }
        public Rect newRect { get; internal set; }
        public GeometryChangedEvent() { bubbles = false; tricklesDown = false; }
    }

    public sealed class AttachToPanelEvent : EventBase<AttachToPanelEvent>
    {
        public IPanel destinationPanel { get; internal set; }
        public AttachToPanelEvent() { bubbles = false; tricklesDown = false; }
    }

    public sealed class DetachFromPanelEvent : EventBase<DetachFromPanelEvent>
    {
        public IPanel originPanel { get; internal set; }
        public DetachFromPanelEvent() { bubbles = false; tricklesDown = false; }
    }

    public sealed class FocusInEvent : EventBase<FocusInEvent> { }
    public sealed class FocusOutEvent : EventBase<FocusOutEvent> { }
    public sealed class FocusEvent : EventBase<FocusEvent> { public FocusEvent() { bubbles = false; } }
    public sealed class BlurEvent : EventBase<BlurEvent> { public BlurEvent() { bubbles = false; } }

    public sealed class ChangeEvent<T> : EventBase<ChangeEvent<T>>
    {
        public T previousValue { get; private set; }
        public T newValue { get; private set; }
        public static ChangeEvent<T> GetPooled(T previousValue, T newValue) => new ChangeEvent<T> { previousValue = previousValue, newValue = newValue };
    }

    public abstract class CallbackEventHandler : IEventHandler
    {
        sealed class Registration
        {
            public Type type;
            public Delegate callback;
            public bool tricklesDown;
            public Action<EventBase> call;
        }

        readonly List<Registration> registrations = new List<Registration>();

        public void RegisterCallback<TEventType>(EventCallback<TEventType> callback, TrickleDown useTrickleDown = TrickleDown.NoTrickleDown) where TEventType : EventBase<TEventType>, new()
        {
            if (callback == null) throw new ArgumentException("callback parameter is null");
            var trickles = useTrickleDown == TrickleDown.TrickleDown;
            if (registrations.Exists(r => r.type == typeof(TEventType) && r.callback.Equals(callback) && r.tricklesDown == trickles)) return;
            registrations.Add(new Registration { type = typeof(TEventType), callback = callback, tricklesDown = trickles, call = e => callback((TEventType)e) });
        }

        public void UnregisterCallback<TEventType>(EventCallback<TEventType> callback, TrickleDown useTrickleDown = TrickleDown.NoTrickleDown) where TEventType : EventBase<TEventType>, new()
        {
            var trickles = useTrickleDown == TrickleDown.TrickleDown;
            registrations.RemoveAll(r => r.type == typeof(TEventType) && r.callback.Equals(callback) && r.tricklesDown == trickles);
        }

        public abstract void SendEvent(EventBase e);

        internal void Call(EventBase e, bool trickling, bool both)
        {
            e.currentTarget = this;
            foreach (var registration in registrations.ToArray())
            {
                if (registration.type != e.GetType() || !both && registration.tricklesDown != trickling) continue;
                registration.call(e);
                if (e.isImmediatePropagationStopped) break;
            }
            e.currentTarget = null;
        }
    }
}
