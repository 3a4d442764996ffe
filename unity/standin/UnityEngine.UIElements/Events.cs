// Events of UI Toolkit: their fields, and how they trickle down and bubble up.
using System;
using System.Collections.Generic;

namespace UnityEngine.UIElements
{
    public enum TrickleDown { NoTrickleDown, TrickleDown }
    public enum PropagationPhase { None, TrickleDown, BubbleUp = 3, AtTarget = 2 }
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
        public void PreventDefault() => isDefaultPrevented = true;
        internal void Ignore() => isDefaultPrevented = true;
        public abstract void Dispose();
    }

    public abstract class EventBase<T> : EventBase where T : EventBase<T>, new()
    {
        public static T GetPooled() => new T();
        public override void Dispose() { }
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
        Vector3 Origin => ((currentTarget ?? target) as VisualElement)?.worldBound.position ?? default;
        public Vector3 localPosition
        {
            get => new Vector3(position.x - Origin.x, position.y - Origin.y, 0);
            protected set => position = new Vector3(value.x + Origin.x, value.y + Origin.y, position.z);
        }
    }

    public sealed class PointerDownEvent : PointerEventBase<PointerDownEvent> { }
    public sealed class PointerMoveEvent : PointerEventBase<PointerMoveEvent> { }
    public sealed class PointerUpEvent : PointerEventBase<PointerUpEvent> { }
    public sealed class PointerCancelEvent : PointerEventBase<PointerCancelEvent> { }
    public sealed class PointerEnterEvent : PointerEventBase<PointerEnterEvent> { public PointerEnterEvent() { bubbles = false; } }
    public sealed class PointerLeaveEvent : PointerEventBase<PointerLeaveEvent> { public PointerLeaveEvent() { bubbles = false; } }
    public sealed class ClickEvent : PointerEventBase<ClickEvent> { }
    
    public abstract class PointerCaptureEventBase<T> : EventBase<T> where T : PointerCaptureEventBase<T>, new() { public int pointerId { get; internal set; } }
    public class PointerCaptureOutEvent : PointerCaptureEventBase<PointerCaptureOutEvent> { }

    public class WheelEvent : MouseEventBase<WheelEvent> { public Vector3 delta { get; internal set; } }

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
        public static T GetPooled(char c, KeyCode keyCode, EventModifiers modifiers) => new T { character = c, keyCode = keyCode, modifiers = modifiers };
    }

    public class KeyDownEvent : KeyboardEventBase<KeyDownEvent> { }
    public class KeyUpEvent : KeyboardEventBase<KeyUpEvent> { }

    public abstract class NavigationEventBase<T> : EventBase<T> where T : NavigationEventBase<T>, new() { }

    /// What the arrow keys also are: it moves the focus unless it is ignored.
    public class NavigationMoveEvent : NavigationEventBase<NavigationMoveEvent>
    {
        public enum Direction { None, Left, Up, Right, Down, Next, Previous }
        public Direction direction { get; internal set; }
    }

    public class GeometryChangedEvent : EventBase<GeometryChangedEvent>
    {
        public Rect oldRect { get; internal set; }
        public Rect newRect { get; internal set; }
        public GeometryChangedEvent() { bubbles = false; tricklesDown = false; }
    }

    public abstract class PanelChangedEventBase<T> : EventBase<T> where T : PanelChangedEventBase<T>, new()
    {
        public IPanel originPanel { get; internal set; }
        public IPanel destinationPanel { get; internal set; }
        protected PanelChangedEventBase() { bubbles = false; tricklesDown = false; }
    }

    public class AttachToPanelEvent : PanelChangedEventBase<AttachToPanelEvent> { }
    public class DetachFromPanelEvent : PanelChangedEventBase<DetachFromPanelEvent> { }

    public abstract class FocusEventBase<T> : EventBase<T> where T : FocusEventBase<T>, new() { }
    public class FocusInEvent : FocusEventBase<FocusInEvent> { }
    public class FocusOutEvent : FocusEventBase<FocusOutEvent> { }
    public class FocusEvent : FocusEventBase<FocusEvent> { public FocusEvent() { bubbles = false; } }
    public class BlurEvent : FocusEventBase<BlurEvent> { public BlurEvent() { bubbles = false; } }

    public class ChangeEvent<T> : EventBase<ChangeEvent<T>>
    {
        public T previousValue { get; protected set; }
        public T newValue { get; protected set; }
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
